"""The display of a running sweep: all jobs and the time left, live in a terminal, plain lines elsewhere."""

import sys
import time
from collections.abc import Sequence
from typing import Self, assert_never

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn

from repro.launch.jobs import Event, EventKind, Job, JobOutcome, JobResult, reason
from repro.tracking.text import duration

_PLAIN_PAUSE_S = 30.0


class Board:
    """Pass it to `run_jobs` as `on_progress`, inside its `with` block; it writes to standard error."""

    def __init__(self, jobs: Sequence[Job], workers: int, *, live: bool | None = None) -> None:
        self.jobs, self.workers = jobs, workers
        self.live = sys.stderr.isatty() if live is None else live
        # Of each job: its share of the work, and the part of it that is done.
        self.shares = [job.expected_s or 1.0 for job in jobs]
        self.fractions = [0.0] * len(jobs)
        self.ended: dict[int, JobResult] = {}
        name, note = (TextColumn(f"{{task.{text}}}", markup=False) for text in ("description", "fields[note]"))
        console = Console(stderr=True, markup=False, emoji=False, highlight=False)
        columns = (SpinnerColumn(), name, BarColumn(), note)
        self._bars = Progress(*columns, console=console, transient=True, disable=not self.live)
        self._all = self._bars.add_task("all jobs", total=len(jobs), note="")
        self._running: dict[int, TaskID] = {}
        self._notices: set[str] = set()
        self._start = self._last_line = time.monotonic()

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bars.stop()

    def __call__(self, event: Event) -> None:
        """Show one event of a job."""
        name = self.jobs[event.index].name
        match event.kind:
            case EventKind.STARTED:
                self._running[event.index] = self._bars.add_task(name, total=1.0, note="")
            case EventKind.PROGRESS:
                self.fractions[event.index] = event.fraction or 0.0
                part = "" if event.fraction is None else f"{event.fraction:.0%}"
                note = f"{part} {event.text}".strip()
                self._bars.update(self._running[event.index], completed=event.fraction or 0.0, note=note)
                if not self.live and time.monotonic() - self._last_line > _PLAIN_PAUSE_S:
                    self._print(f"{self._summary()}; now {name} {note}".rstrip())
            case EventKind.NOTICE:
                if event.text not in self._notices:  # what concerns all jobs is said by each
                    self._notices.add(event.text)
                    self._print(f"{name}: {event.text}")
            case EventKind.ENDED:
                if event.index in self._running:  # a job that died at once has not started
                    self._bars.remove_task(self._running.pop(event.index))
                if (result := event.result) is not None:
                    self.fractions[event.index], self.ended[event.index] = 1.0, result
                    if not (result.ok and self.live):
                        state = "done" if result.ok else reason(result)
                        count = f"[{len(self.ended)}/{len(self.jobs)}]"
                        line = f"{count} {name}: {state} ({duration(result.seconds)})"
                        self._print("; ".join(filter(None, (line, self._left()))))
            case _:
                assert_never(event.kind)
        self._bars.update(self._all, completed=len(self.ended), note=self._summary())

    def seconds_left(self) -> float | None:
        """Seconds until the last job ends: at the pace so far, before that by what the jobs are expected to take."""
        whole = sum(self.shares)
        done = sum(share * fraction for share, fraction in zip(self.shares, self.fractions, strict=True))
        if done > 0:
            return (whole - done) / done * (time.monotonic() - self._start)
        expected = all(job.expected_s is not None for job in self.jobs)
        return whole / min(self.workers, len(self.jobs)) if expected else None

    def _left(self) -> str:
        stopping = any(result.outcome is JobOutcome.INTERRUPTED for result in self.ended.values())
        left = self.seconds_left() if len(self.ended) < len(self.jobs) and not stopping else None
        return "" if left is None else f"about {duration(left)} left"

    def _summary(self) -> str:
        failed = sum(not result.ok for result in self.ended.values())
        words = [f"{len(self.ended)} of {len(self.jobs)} done", f"{failed} failed" if failed else "", self._left()]
        return ", ".join(filter(None, words))

    def _print(self, line: str) -> None:
        self._last_line = time.monotonic()
        self._bars.console.print(line, soft_wrap=True)
