"""Runs one job in a child process and always reports an outcome."""

import faulthandler
import os
import signal
import sys
import threading
import traceback
from contextlib import suppress
from importlib import import_module
from multiprocessing import connection, parent_process
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.launch.jobs import Event, EventKind, Job, JobOutcome, JobResult
from repro.launch.machine import reuse_freed_memory
from repro.tracking import code, progress
from repro.tracking.files import disk_errors_explained
from repro.tracking.store import StageFailed


def main(pipe: connection.Connection, index: int, job: Job, log: str) -> None:
    """Call the job's target and send STARTED once it can end gracefully, at last ENDED with the result."""

    def end(outcome: JobOutcome, value: Any = None, error: str = "", trace: str = "") -> None:
        pipe.send(Event(EventKind.ENDED, index, result=JobResult(job, outcome, value, error, trace)))

    # A process group of its own: Ctrl-C in the terminal reaches the launcher alone, which passes it on.
    os.setpgid(0, 0)
    # The server ignores Ctrl-C; a job obeys the one that the launcher passes on.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=_die_with_launcher, daemon=True).start()
    reuse_freed_memory()
    code.begin_job()
    progress.listen(
        lambda fraction, text: pipe.send(Event(EventKind.PROGRESS, index, fraction, text)),
        lambda text: pipe.send(Event(EventKind.NOTICE, index, text=text)),
        log,
    )
    try:
        pipe.send(Event(EventKind.STARTED, index))
        with disk_errors_explained(Path(log).parent):
            _print_into(log)
        module, _, name = job.target.partition(":")
        end(JobOutcome.OK, getattr(import_module(module), name)(**job.arguments))
    except KeyboardInterrupt:
        end(JobOutcome.INTERRUPTED)
    except StageFailed as error:
        failure = error.record.failure
        assert failure is not None
        end(JobOutcome.FAILED, error=f"{failure.type}: {failure.message}", trace=failure.trace)
        _print_trace()
    except UserError as error:
        end(JobOutcome.FAILED, error=str(error))
    except Exception as error:
        end(JobOutcome.FAILED, error=f"{type(error).__name__}: {error}", trace=traceback.format_exc())
        _print_trace()


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
    sys.stdout.flush()
    sys.stderr.flush()
    with Path(log).open("wb") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):
            stream.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    faulthandler.enable()
