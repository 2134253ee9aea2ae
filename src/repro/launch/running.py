"""A job while it runs: its process, what it says, and how it ended."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from repro.launch import worker
from repro.launch.jobs import Event, Job, JobResult

_EXIT_S = 2.0
_TAIL_LINES = 15


class Running:
    """Starts a job in a process forked from the server.

    pipe, process  readable and ready, respectively, when there is something to hear
    ready          it can end gracefully when interrupted
    interrupts     how many Ctrl-C it has been told of
    timed_out      the launcher killed it for taking too long
    """

    def __init__(self, index: int, job: Job, logs: Path) -> None:
        self.index = index
        self.job = job
        self.log = logs / f"{index:04d}-{re.sub(r'[^A-Za-z0-9._=-]+', '-', job.name)[:80]}.log"
        context = multiprocessing.get_context("forkserver")
        self.pipe, theirs = context.Pipe(duplex=False)
        arguments = (theirs, job.target, job.arguments, str(self.log))
        self.process = context.Process(target=worker.main, args=arguments, name=job.name)
        self.process.start()
        theirs.close()
        self.started = time.monotonic()
        self.ready = False
        self.interrupts = 0
        self.timed_out = False
        self._answer: tuple[str, Any] | None = None

    @property
    def seconds(self) -> float:
        """Seconds since it started."""
        return time.monotonic() - self.started

    def signal(self, number: signal.Signals) -> None:
        """Signal the job and every process it has started."""
        pid = self.process.pid
        if pid is not None and self.process.is_alive():
            with suppress(ProcessLookupError):
                try:
                    os.killpg(pid, number)
                except ProcessLookupError:  # it has not yet made its own group
                    os.kill(pid, number)

    def heard(self) -> Iterator[Event]:
        """What it has said since the last call."""
        for what, content in iter(self._receive, None):
            if what == "ready":
                self.ready = True
            elif what == "progress":
                fraction, text = content
                yield Event("progress", self.index, self.job, fraction, text)
            elif what == "notice":
                yield Event("notice", self.index, self.job, text=content)
            else:
                self._answer = (what, content)

    def has_ended(self, *, alive: bool) -> bool:
        """Whether it has given its answer, or was not alive before it was last listened to."""
        return self._answer is not None or not alive

    def end(self, *, interrupted: bool) -> JobResult:
        """Wait for the process, kill it if it lingers, and tell how the job ended."""
        seconds = self.seconds
        self.process.join(_EXIT_S)
        self.signal(signal.SIGKILL)
        self.process.join()
        self.pipe.close()
        if self._answer is not None and self._answer[0] == "ok":
            if self.log.is_file() and not self.log.stat().st_size:
                self.log.unlink()
            log = str(self.log) if self.log.is_file() else ""
            return JobResult(self.job, "ok", self._answer[1], seconds=seconds, log=log)
        outcome, error = self._answer or self._death(interrupted)
        return JobResult(self.job, outcome, error=error, seconds=seconds, log=str(self.log))

    def _receive(self) -> tuple[str, Any] | None:
        try:
            return self.pipe.recv() if self._answer is None and self.pipe.poll() else None
        except (EOFError, OSError):
            return None  # it died; its exit code tells the rest
        except Exception as error:
            message = f"its answer cannot be read here: {error}"
            return "failed", {"type": type(error).__name__, "message": message, "trace": ""}

    def _death(self, interrupted: bool) -> tuple[str, dict[str, str] | None]:
        """Outcome and error of a job that died without an answer."""
        if interrupted:
            return "interrupted", None
        if self.timed_out:
            outcome, message = "timed out", f"killed after {self.seconds:.3g} s"
        else:
            outcome, message = "killed", _exit_text(self.process.exitcode)
        lines = self.log.read_text(errors="replace").splitlines() if self.log.is_file() else []
        return outcome, {"message": message, "trace": "\n".join(lines[-_TAIL_LINES:])}


def _exit_text(code: int | None) -> str:
    if code is not None and code < 0:
        name = signal.Signals(-code).name
        hint = ", often for lack of memory: try fewer workers" if name == "SIGKILL" else ""
        return f"ended by {name}{hint}"
    return f"ended without a result, exit code {code}"
