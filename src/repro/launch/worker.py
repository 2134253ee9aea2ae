"""Runs one function in a child process and always reports an outcome."""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
import traceback
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import connection, parent_process
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.launch.jobs import JobError, JobOutcome
from repro.tracking import code, progress
from repro.tracking.files import disk_errors_explained
from repro.tracking.store import StageFailed


@dataclass(frozen=True)
class Ready:
    """The job can end gracefully from now on when it is interrupted."""


@dataclass(frozen=True)
class ProgressReport:
    """Finished part of the job (0 to 1, None when unknown) and what it is doing."""

    fraction: float | None
    text: str


@dataclass(frozen=True)
class Notice:
    """One line that the user should see."""

    text: str


@dataclass(frozen=True)
class Ending:
    """The last message of a job."""

    outcome: JobOutcome
    value: Any = None
    error: JobError | None = None


Message = Ready | ProgressReport | Notice | Ending


class _Channel:
    """Sends progress and notices to the launcher."""

    def __init__(self, pipe: connection.Connection) -> None:
        self.pipe = pipe

    def report(self, fraction: float | None, text: str) -> None:
        self.pipe.send(ProgressReport(fraction, text))

    def notice(self, text: str) -> None:
        self.pipe.send(Notice(text))


def main(pipe: connection.Connection, target: str, arguments: Mapping[str, object], log: str) -> None:
    """Call `target` ("module:function") with the arguments and send an Ending with its value or its exception."""
    # A process group of its own: Ctrl-C in the terminal reaches the launcher alone, which passes it on.
    os.setpgid(0, 0)
    # The server ignores Ctrl-C; a job obeys the one that the launcher passes on.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=_die_with_launcher, daemon=True).start()
    code.begin_job()
    progress.listen(_Channel(pipe), log)
    try:
        pipe.send(Ready())
        with disk_errors_explained(Path(log).parent):
            _print_into(log)
        module, _, name = target.partition(":")
        pipe.send(Ending(JobOutcome.OK, getattr(import_module(module), name)(**arguments)))
    except KeyboardInterrupt:
        pipe.send(Ending(JobOutcome.INTERRUPTED))
    except StageFailed as error:
        failure = error.record.failure
        assert failure is not None
        pipe.send(_failed(JobError(failure.message, failure.type, failure.trace)))
        _print_trace()
    except UserError as error:
        pipe.send(_failed(JobError(str(error))))
    except Exception as error:
        trace = "".join(traceback.format_exception(error))
        pipe.send(_failed(JobError(str(error), type(error).__name__, trace)))
        _print_trace()


def _failed(error: JobError) -> Ending:
    return Ending(JobOutcome.FAILED, error=error)


def _print_trace() -> None:
    # A full disk takes no more of the log; the launcher already has the error.
    with suppress(OSError):
        traceback.print_exc()


def _die_with_launcher() -> None:
    launcher = parent_process()
    if launcher is not None:
        connection.wait([launcher.sentinel])
        os.killpg(os.getpgrp(), signal.SIGKILL)


def _print_into(log: str) -> None:
    """Send standard output and error, those of C libraries too, to a file."""
    Path(log).parent.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
    sys.stdout.flush()
    sys.stderr.flush()
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    os.close(descriptor)
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):
            stream.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    faulthandler.enable()
