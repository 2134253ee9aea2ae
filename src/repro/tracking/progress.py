"""Progress and notices of a job; the listener decides what is shown.

In a job of a sweep they are sent to the launcher; elsewhere notices go to standard error.
"""

from __future__ import annotations

import sys
import time
from typing import Protocol

_SHORTEST_PAUSE_S = 0.2


class Listener(Protocol):
    """Receives the progress and notices of a job."""

    def report(self, fraction: float | None, text: str) -> None:
        """Receive the finished part (0 to 1, None when unknown) and what is being done."""

    def notice(self, text: str) -> None:
        """Receive one line that the user should see."""


class _Terminal:
    def report(self, fraction: float | None, text: str) -> None:
        """A single run shows its results, not its progress."""

    def notice(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)


_listener: Listener = _Terminal()
_log = ""
_last = float("-inf")


def report(fraction: float | None, text: str = "") -> None:
    """Report how much of the job is done (0 to 1, None when unknown); cheap enough to call in every iteration."""
    global _last  # noqa: PLW0603 - one job a process
    now = time.monotonic()
    if now - _last >= _SHORTEST_PAUSE_S or fraction == 1:
        _last = now
        _listener.report(fraction, text)


def notice(text: str) -> None:
    """Show one line to the user."""
    _listener.notice(text)


def listen(listener: Listener, log: str = "") -> None:
    """Send progress and notices of this process to one listener; `log` is the file that takes its printed output."""
    global _listener, _log
    _listener, _log = listener, log


def log_path() -> str:
    """The file that takes this process's printed output; empty when it goes to the terminal."""
    return _log
