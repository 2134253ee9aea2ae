"""The inside of a job: one function call in a process of its own that always tells how it ended."""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
import traceback
from contextlib import suppress
from dataclasses import asdict
from importlib import import_module
from multiprocessing import connection, parent_process
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking import code, progress
from repro.tracking.files import disk_errors_explained
from repro.tracking.store import StageFailed


class _Channel:
    """Sends what the job says to the launcher."""

    def __init__(self, pipe: connection.Connection) -> None:
        self.pipe = pipe

    def report(self, fraction: float | None, text: str) -> None:
        self.pipe.send(("progress", (fraction, text)))

    def notice(self, text: str) -> None:
        self.pipe.send(("notice", text))


def main(pipe: connection.Connection, target: str, arguments: dict[str, Any], log: str) -> None:
    """Call `target` ("module:function") with the arguments and send its value or its exception to the launcher."""
    # A process group of its own: Ctrl-C in the terminal reaches the launcher alone, which passes it on.
    os.setpgid(0, 0)
    # The server ignores Ctrl-C, a job obeys the launcher's.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Thread(target=_die_with_launcher, daemon=True).start()
    code.begin_job()
    progress.listen(_Channel(pipe), log)
    try:
        pipe.send(("ready", None))
        with disk_errors_explained(Path(log).parent):
            _print_into(log)
        module, _, name = target.partition(":")
        pipe.send(("ok", getattr(import_module(module), name)(**arguments)))
    except KeyboardInterrupt:
        pipe.send(("interrupted", None))
    except StageFailed as failure:
        pipe.send(("failed", asdict(failure.record.failure) if failure.record.failure else {}))
        _print_trace()
    except UserError as error:
        pipe.send(("failed", {"type": "", "message": str(error), "trace": ""}))
    except Exception as error:
        trace = "".join(traceback.format_exception(error))
        pipe.send(("failed", {"type": type(error).__name__, "message": str(error), "trace": trace}))
        _print_trace()


def _print_trace() -> None:
    # On a full disk the log takes nothing more; the launcher has been told already.
    with suppress(OSError):
        traceback.print_exc()


def _die_with_launcher() -> None:
    launcher = parent_process()
    if launcher is not None:
        connection.wait([launcher.sentinel])
        os.killpg(os.getpgrp(), signal.SIGKILL)


def _print_into(log: str) -> None:
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
