"""The launcher: every job in a fresh process, forked from a server that has loaded the heavy libraries once.

Whatever a job does (raise, os._exit, run out of memory, hang) costs that job alone. The first Ctrl-C starts no more
jobs and interrupts the running ones, which keep their checkpoints; the second kills them. Jobs die with their launcher.
Editing a module that the server has loaded changes no job of this sweep.
"""

import atexit
import multiprocessing
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from multiprocessing import connection, forkserver
from pathlib import Path
from types import FrameType, ModuleType

from repro.errors import UserError
from repro.launch import worker
from repro.launch.jobs import Event, EventKind, Job, JobOutcome, JobResult
from repro.launch.machine import memory_for_jobs_mib
from repro.tracking import progress
from repro.tracking.paths import Paths, outputs_root

SERVER_ENDED = (
    "the process that starts the jobs was ended from outside, often for lack of memory: try fewer --workers. "
    "Finished work is kept; the same command goes on from there"
)
_TICK_S, _EXIT_S = 0.2, 2.0
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
) -> list[JobResult]:
    """Run the jobs, at most `workers` at once and as many as there is memory for; how each ended, in their order.

    timeout_s   a job that takes longer is killed
    preload     modules the server loads before the first job
    on_progress takes an Event at every change, in the calling thread
    logs        folder of the jobs' printed output (default: a new one under outputs/logs)

    Raises KeyboardInterrupt, whose argument are the results, after Ctrl-C.
    """
    start_server(preload)
    if logs is None:
        logs = Paths(outputs_root()).logs / f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    waiting = list(enumerate(jobs))
    launcher = _Launcher(waiting, max(1, workers), memory_for_jobs_mib(), timeout_s, on_progress, logs)
    with _interrupts(launcher.interrupt):
        try:
            launcher.run()
        finally:
            for job in launcher.running:
                job.signal(signal.SIGKILL)
            # Jobs that printed nothing leave no log; a folder with logs stays.
            with suppress(OSError):
                logs.rmdir()
    results = [launcher.results.get(index) or JobResult(job, JobOutcome.NOT_STARTED) for index, job in enumerate(jobs)]
    if launcher.interrupts:
        raise KeyboardInterrupt(results)
    return results


def start_server(preload: Sequence[str]) -> None:
    """Start the server that all jobs are forked from, unless it runs; it loads the modules in the background."""
    # The libraries read these when they are loaded, which happens in the server; one thread, unless the user sets more.
    for variable in _THREAD_VARIABLES:
        os.environ.setdefault(variable, "1")
    os.environ["REPRO_JOB_SERVER_OF"] = str(os.getpid())  # read by watch_parent, which this process must not load
    watched = [f"{__package__}.watch_parent", worker.__name__, *preload, f"{__package__}.preloaded"]
    multiprocessing.set_forkserver_preload(watched)
    # Ctrl-C reaches the launcher alone, also while the server still loads.
    with _interrupts(signal.SIG_IGN):
        forkserver.ensure_running()
    atexit.unregister(_stop_server)
    atexit.register(_stop_server)


def _stop_server() -> None:
    """End the server at once: while it loads modules it would outlive its command, and hold the pipe of its output."""
    server = vars(forkserver)["_forkserver"]  # there is no public name for it
    if server._forkserver_pid is not None:
        with suppress(ProcessLookupError):
            os.kill(server._forkserver_pid, signal.SIGKILL)


class _Running:
    """A job while it runs, in a process forked from the server.

    pipe, process  readable and ready, respectively, when there is something new
    result         as its last message says it
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
        self.result: JobResult | None = None

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
        try:
            while self.result is None and self.pipe.poll():
                event: Event = self.pipe.recv()
                self.ready, self.result = True, event.result
                if event.result is None:
                    yield event
        except (EOFError, OSError):
            return  # it died; its exit code shows how
        except Exception as error:
            text = f"{type(error).__name__}: its value cannot be read by the launcher: {error}"
            self.ready, self.result = True, JobResult(self.job, JobOutcome.FAILED, error=text)

    def end(self, *, interrupted: bool) -> JobResult:
        """Wait for the process, kill it if it lingers, and return how the job ended."""
        seconds = self.seconds
        self.process.join(_EXIT_S)
        self.signal(signal.SIGKILL)
        self.process.join()
        self.pipe.close()
        result = self.result or self._death(interrupted)
        log = str(self.log)
        if result.ok and self.log.is_file() and not self.log.stat().st_size:
            self.log.unlink()
            log = ""
        return replace(result, seconds=seconds, log=log)

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
        return JobResult(self.job, outcome, error=message, trace="\n".join(lines[-_TAIL_LINES:]))


@dataclass
class _Launcher:
    """The jobs that wait, run and have ended."""

    waiting: list[tuple[int, Job]]
    workers: int
    memory_mib: float
    timeout_s: float | None
    on_progress: Callable[[Event], None]
    logs: Path
    running: list[_Running] = field(default_factory=list)
    results: dict[int, JobResult] = field(default_factory=dict)
    interrupts: int = 0
    announced: bool = False

    def run(self) -> None:
        """Until every job has ended, or the running ones have after Ctrl-C."""
        while self.running or (self.waiting and not self.interrupts):
            while not self.interrupts and (place := self._next()) is not None:
                self.running.append(_Running(*self.waiting.pop(place), self.logs))
            self._pass_on_interrupts()
            connection.wait(
                [source for job in self.running for source in (job.pipe, job.process.sentinel)], timeout=_TICK_S
            )
            for job in list(self.running):
                self._attend(job)

    def _next(self) -> int | None:
        """Place of the first waiting job that there is a worker and memory for; one runs whatever it takes."""
        if not self.running:
            return 0 if self.waiting else None
        free = self.memory_mib - sum(job.job.expected_mib for job in self.running)
        places = (place for place, (_, job) in enumerate(self.waiting) if job.expected_mib <= free)
        return next(places, None) if len(self.running) < self.workers else None

    def interrupt(self, number: int, frame: FrameType | None) -> None:
        """Count a Ctrl-C; the loop acts on it, at a point where nothing is half done."""
        self.interrupts += 1

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
        ended = not job.process.is_alive()  # looked at before its messages, the last of which may lie there still
        for event in job.events():
            self.on_progress(event)
        ended = ended or job.result is not None
        if not ended and self.timeout_s is not None and job.seconds > self.timeout_s:
            job.timed_out = ended = True
            job.signal(signal.SIGKILL)
        if ended:
            result = job.end(interrupted=self.interrupts > 0)
            self.running.remove(job)
            self.results[job.index] = result
            self.on_progress(Event(EventKind.ENDED, job.index, result=result))


@contextmanager
def _interrupts(handler: Callable[[int, FrameType | None], None] | signal.Handlers) -> Iterator[None]:
    """Take Ctrl-C over for a while; outside the main thread Python allows no handlers, and it stays as it is."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
