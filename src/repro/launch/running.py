"""A job while it runs: its process, its messages, and how it ended."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import ModuleType

from repro.errors import UserError
from repro.launch import worker
from repro.launch.jobs import Event, EventKind, Job, JobError, JobOutcome, JobResult

SERVER_ENDED = (
    "the process that starts the jobs was ended from outside, often for lack of memory: try fewer --workers. "
    "Finished work is kept; the same command goes on from there"
)
_EXIT_S = 2.0
_TAIL_LINES = 15


class Running:
    """Starts a job in a process forked from the server.

    pipe, process  readable and ready, respectively, when `events` or `has_ended` have something new
    ready          it can end gracefully when interrupted
    interrupts     how many Ctrl-C were passed on to it
    timed_out      the launcher killed it for taking too long
    """

    def __init__(self, index: int, job: Job, logs: Path) -> None:
        self.index = index
        self.job = job
        self.log = logs / f"{index:04d}-{re.sub(r'[^A-Za-z0-9._=-]+', '-', job.name)[:80]}.log"
        context = multiprocessing.get_context("forkserver")
        self.pipe, end_of_job = context.Pipe(duplex=False)
        arguments = (end_of_job, index, job, str(self.log))
        self.process = context.Process(target=worker.main, args=arguments, name=job.name)
        # A child would run the main module again; jobs are functions of other modules.
        main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
        try:
            self.process.start()
        except (EOFError, ConnectionError):
            raise UserError(SERVER_ENDED) from None
        finally:
            sys.modules["__main__"] = main
            end_of_job.close()
        self.started = time.monotonic()
        self.ready = False
        self.interrupts = 0
        self.timed_out = False
        self._result: JobResult | None = None

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

    def events(self) -> Iterator[Event]:
        """What happened since the last call, all but the end."""
        while (event := self._receive()) is not None:
            self.ready = True
            self._result = event.result
            if event.result is None:
                yield event

    def has_ended(self, *, alive: bool) -> bool:
        """Whether its last message has arrived, or it was not alive before its messages were last read."""
        return self._result is not None or not alive

    def end(self, *, interrupted: bool) -> JobResult:
        """Wait for the process, kill it if it lingers, and return how the job ended."""
        seconds = self.seconds
        self.process.join(_EXIT_S)
        self.signal(signal.SIGKILL)
        self.process.join()
        self.pipe.close()
        result = self._result or self._death(interrupted)
        log = str(self.log)
        if result.ok and self.log.is_file() and not self.log.stat().st_size:
            self.log.unlink()
            log = ""
        return replace(result, seconds=seconds, log=log)

    def _receive(self) -> Event | None:
        try:
            event: Event | None = self.pipe.recv() if self._result is None and self.pipe.poll() else None
            return event
        except (EOFError, OSError):
            return None  # it died; its exit code shows how
        except Exception as error:
            text = f"its value cannot be read by the launcher: {error}"
            result = JobResult(self.job, JobOutcome.FAILED, error=JobError(text, type(error).__name__))
            return Event(EventKind.ENDED, self.index, result=result)

    def _death(self, interrupted: bool) -> JobResult:
        """How a job ended that died without a last message."""
        if interrupted:
            return JobResult(self.job, JobOutcome.INTERRUPTED)
        if self.timed_out:
            outcome, message = JobOutcome.TIMED_OUT, f"killed after {self.seconds:.3g} s"
        else:
            outcome, message = JobOutcome.KILLED, f"ended without a result, exit code {self.process.exitcode}"
            if (code := self.process.exitcode or 0) < 0:
                hint = ", often for lack of memory: try fewer workers" if code == -signal.SIGKILL else ""
                message = f"ended by {signal.Signals(-code).name}{hint}"
        lines = self.log.read_text(errors="replace").splitlines() if self.log.is_file() else []
        return JobResult(self.job, outcome, error=JobError(message, trace="\n".join(lines[-_TAIL_LINES:])))
