"""Progress and notices of a job; the listener decides what is shown.

In a job of a sweep they are sent to the launcher; elsewhere only notices are shown, on standard error.
"""

import logging
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

_SHORTEST_PAUSE_S = 0.2


@dataclass
class _Listener:
    """Where this process sends its progress and notices, and `log`, the file that takes its printed output."""

    report: Callable[[float | None, str], None] | None = None
    notice: Callable[[str], None] = lambda text: print(text, file=sys.stderr, flush=True)
    log: str = ""
    last_report: float = float("-inf")
    logged: set[str] = field(default_factory=set)
    collected: list[str] = field(default_factory=list)


_listener = _Listener()


def listen(report: Callable[[float | None, str], None], notice: Callable[[str], None], log: str) -> None:
    """Send progress and notices of this process to these functions; `log` is the file that takes its printed output."""
    _listener.report, _listener.notice, _listener.log = report, notice, log


@contextmanager
def watched(report: Callable[[float | None, str], None]) -> Iterator[None]:
    """Send the progress of this process to a function inside the block."""
    before, _listener.report = _listener.report, report
    try:
        yield
    finally:
        _listener.report = before


def report(fraction: float | None, text: str = "") -> None:
    """Report how much of the job is done (0 to 1, None when unknown); cheap enough to call in every iteration."""
    now = time.monotonic()
    if _listener.report is not None and (now - _listener.last_report >= _SHORTEST_PAUSE_S or fraction == 1):
        _listener.last_report = now
        _listener.report(fraction, text)


def notice(text: str) -> None:
    """Show one line to the user."""
    _listener.collected.append(text)
    _listener.notice(text)


@contextmanager
def collected() -> Iterator[list[str]]:
    """The notices given inside the block, as they come."""
    before, _listener.collected = _listener.collected, []
    try:
        yield _listener.collected
    finally:
        _listener.collected = before


class _LoggedNotices(logging.Handler):
    """Shows what rooms that import nothing of this one have logged, once per process."""

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if text not in _listener.logged:
            _listener.logged.add(text)
            notice(text)


logging.getLogger("repro").addHandler(_LoggedNotices())


def log_path() -> str:
    """The file that takes this process's printed output; empty when it goes to the terminal."""
    return _listener.log
