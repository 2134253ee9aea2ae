"""Progress and notices of a job; the listener decides what is shown.

In a job of a sweep they are sent to the launcher; elsewhere only notices are shown, on standard error.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

_SHORTEST_PAUSE_S = 0.2


@dataclass
class _Listener:
    """Where this process sends its progress and notices, and `log`, the file that takes its printed output."""

    report: Callable[[float | None, str], None] | None = None
    notice: Callable[[str], None] | None = None
    log: str = ""
    last_report: float = float("-inf")


_listener = _Listener()


def listen(report: Callable[[float | None, str], None], notice: Callable[[str], None], log: str) -> None:
    """Send progress and notices of this process to these functions; `log` is the file that takes its printed output."""
    _listener.report, _listener.notice, _listener.log = report, notice, log


def report(fraction: float | None, text: str = "") -> None:
    """Report how much of the job is done (0 to 1, None when unknown); cheap enough to call in every iteration."""
    now = time.monotonic()
    if _listener.report is not None and (now - _listener.last_report >= _SHORTEST_PAUSE_S or fraction == 1):
        _listener.last_report = now
        _listener.report(fraction, text)


def notice(text: str) -> None:
    """Show one line to the user."""
    if _listener.notice is not None:
        _listener.notice(text)
    else:
        print(text, file=sys.stderr, flush=True)


def log_path() -> str:
    """The file that takes this process's printed output; empty when it goes to the terminal."""
    return _listener.log
