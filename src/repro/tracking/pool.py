"""The launcher: every job in a fresh process, forked from a server that has loaded the heavy libraries once.

Whatever a job does (raise, os._exit, run out of memory, hang) costs that job alone. Ctrl-C once starts no more jobs and
asks the running ones to end, which keep their checkpoints; twice kills them. Jobs die with their launcher.
"""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import connection
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from types import FrameType
from typing import Any

from repro.tracking import progress, worker
from repro.tracking.jobs import Event, Job, JobResult, SweepInterrupted
from repro.tracking.paths import Paths, outputs_root

_TICK_S = 0.2
_EXIT_S = 2.0
_TAIL_LINES = 15
_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def run_jobs(
    jobs: Sequence[Job],
    *,
    workers: int,
    timeout_s: float | None = None,
    preload: Sequence[str] = ("torch",),
    on_progress: Callable[[Event], None] = lambda event: None,
    logs: Path | None = None,
    threads: int = 1,
) -> list[JobResult]:
    """Run the jobs, at most `workers` at once, and return how each ended, in their order.

    timeout_s   a job that takes longer is killed
    preload     modules the server loads before the first job
    on_progress takes an Event at every change, in the calling thread
    logs        folder of the jobs' printed output (default: a new one under outputs/logs)
    threads     threads of the numerical libraries in each job, unless the environment already says

    Raises SweepInterrupted (a KeyboardInterrupt that carries the results) after Ctrl-C.
    """
    # The libraries read these when they are loaded, which happens in the server.
    for variable in _THREAD_VARIABLES:
        os.environ.setdefault(variable, str(threads))
    multiprocessing.set_forkserver_preload([*preload, worker.__name__])
    if logs is None:
        logs = Paths(outputs_root()).logs / f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    launcher = _Launcher(list(jobs), max(1, workers), timeout_s, on_progress, logs)
    with _interrupts(launcher.interrupt):
        try:
            launcher.run()
        finally:
            launcher.kill_all()
    results = [launcher.results.get(index) or JobResult(job, "not started") for index, job in enumerate(jobs)]
    if launcher.interrupts:
        raise SweepInterrupted(results)
    return results


@dataclass
class _Running:
    index: int
    job: Job
    process: ForkServerProcess
    pipe: connection.Connection
    log: Path
    started: float = field(default_factory=time.monotonic)
    ready: bool = False
    interrupts: int = 0
    answer: tuple[str, Any] | None = None
    timed_out: bool = False

    def signal(self, number: signal.Signals) -> None:
        """Signal the job and every process it has started."""
        pid = self.process.pid
        if pid is not None and self.process.is_alive():
            with suppress(ProcessLookupError):
                try:
                    os.killpg(pid, number)
                except ProcessLookupError:  # it has not yet made its own group
                    os.kill(pid, number)


class _Launcher:
    def __init__(
        self,
        jobs: list[Job],
        workers: int,
        timeout_s: float | None,
        on_progress: Callable[[Event], None],
        logs: Path,
    ) -> None:
        self.waiting = list(enumerate(jobs))[::-1]
        self.workers = workers
        self.timeout_s = timeout_s
        self.on_progress = on_progress
        self.logs = logs
        self.running: list[_Running] = []
        self.results: dict[int, JobResult] = {}
        self.interrupts = 0
        self.announced = False

    def run(self) -> None:
        """Until every job has ended, or the running ones have after Ctrl-C."""
        while self.running or (self.waiting and not self.interrupts):
            while self.waiting and len(self.running) < self.workers and not self.interrupts:
                self._start(*self.waiting.pop())
            self._pass_on_interrupts()
            connection.wait([watched for job in self.running for watched in _watched(job)], timeout=_TICK_S)
            for job in list(self.running):
                self._attend(job)

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """Count a Ctrl-C; the loop acts on it, at a point where nothing is half done."""
        self.interrupts += 1

    def kill_all(self) -> None:
        """Kill what still runs."""
        for job in self.running:
            job.signal(signal.SIGKILL)

    def _start(self, index: int, job: Job) -> None:
        log = self.logs / f"{index:04d}-{re.sub(r'[^A-Za-z0-9._=-]+', '-', job.name)[:80]}.log"
        context = multiprocessing.get_context("forkserver")
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(
            target=worker.main, args=(theirs, job.target, job.arguments, str(log)), name=job.name, daemon=False
        )
        process.start()
        theirs.close()
        self.running.append(_Running(index, job, process, ours, log))
        self.on_progress(Event("started", index, job))

    def _pass_on_interrupts(self) -> None:
        if self.interrupts and not self.announced:
            self.announced = True
            progress.notice("stopping: running jobs keep their checkpoints and end; Ctrl-C again kills them")
        for job in self.running:
            # A job that is not ready could not yet end gracefully.
            if job.interrupts < self.interrupts and (job.ready or self.interrupts > 1):
                job.interrupts = self.interrupts
                job.signal(signal.SIGINT if self.interrupts == 1 else signal.SIGKILL)

    def _attend(self, job: _Running) -> None:
        alive = job.process.is_alive()
        self._listen(job)
        if job.answer is not None or not alive:
            self._end(job)
        elif self.timeout_s is not None and time.monotonic() - job.started > self.timeout_s:
            job.timed_out = True
            job.signal(signal.SIGKILL)
            self._end(job)

    def _listen(self, job: _Running) -> None:
        try:
            while job.answer is None and job.pipe.poll():
                what, content = job.pipe.recv()
                if what == "ready":
                    job.ready = True
                elif what == "progress":
                    fraction, text = content
                    self.on_progress(Event("progress", job.index, job.job, fraction, text))
                elif what == "notice":
                    self.on_progress(Event("notice", job.index, job.job, text=content))
                else:
                    job.answer = (what, content)
        except (EOFError, OSError):
            return  # it died; its exit code tells the rest
        except Exception as error:
            message = f"its answer cannot be read here: {error}"
            job.answer = ("failed", {"type": type(error).__name__, "message": message, "trace": ""})

    def _end(self, job: _Running) -> None:
        job.process.join(_EXIT_S)
        job.signal(signal.SIGKILL)
        job.process.join()
        job.pipe.close()
        self.running.remove(job)
        result = self._result(job)
        self.results[job.index] = result
        self.on_progress(Event("ended", job.index, job.job, result=result))

    def _result(self, job: _Running) -> JobResult:
        seconds = time.monotonic() - job.started
        log = str(job.log)
        if job.answer is not None:
            outcome, content = job.answer
            if outcome == "ok":
                if job.log.is_file() and not job.log.stat().st_size:
                    job.log.unlink()
                return JobResult(job.job, "ok", content, seconds=seconds, log=log if job.log.is_file() else "")
            return JobResult(job.job, outcome, error=content, seconds=seconds, log=log)
        if self.interrupts:
            return JobResult(job.job, "interrupted", seconds=seconds, log=log)
        if job.timed_out:
            outcome, message = "timed out", f"took longer than {self.timeout_s:g} s"
        else:
            outcome, message = "killed", _exit_text(job.process.exitcode)
        return JobResult(job.job, outcome, None, {"message": message, "trace": _tail(job.log)}, seconds, log)


def _watched(job: _Running) -> tuple[Any, Any]:
    return job.pipe, job.process.sentinel


def _exit_text(code: int | None) -> str:
    if code is not None and code < 0:
        name = signal.Signals(-code).name
        hint = ", often for lack of memory: try fewer workers" if name == "SIGKILL" else ""
        return f"ended by {name}{hint}"
    return f"ended without a result, exit code {code}"


def _tail(log: Path) -> str:
    if not log.is_file():
        return ""
    return "\n".join(log.read_text(errors="replace").splitlines()[-_TAIL_LINES:])


@contextmanager
def _interrupts(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Take Ctrl-C over while jobs run; outside the main thread Python allows no handlers, and it stays as it is."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
