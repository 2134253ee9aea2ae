"""The display of a running sweep: all jobs and the time left, live in a terminal, plain lines elsewhere."""

from __future__ import annotations

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
        self.clock = Clock(jobs, workers)
        self.live = sys.stderr.isatty() if live is None else live
        name, note = (TextColumn(f"{{task.{text}}}", markup=False) for text in ("description", "fields[note]"))
        console = Console(stderr=True, markup=False, emoji=False, highlight=False)
        columns = (SpinnerColumn(), name, BarColumn(), note)
        self._bars = Progress(*columns, console=console, transient=True, disable=not self.live)
        self._all = self._bars.add_task("all jobs", total=len(self.clock.jobs), note="")
        self._running: dict[int, TaskID] = {}
        self._notices: set[str] = set()
        self._last_line = time.monotonic()

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._bars.stop()

    def __call__(self, event: Event) -> None:
        """Show one event of a job."""
        self.clock.take(event)
        name = self.clock.jobs[event.index].name
        match event.kind:
            case EventKind.STARTED:
                self._running[event.index] = self._bars.add_task(name, total=1.0, note="")
            case EventKind.PROGRESS:
                part = "" if event.fraction is None else f"{event.fraction:.0%}"
                note = f"{part} {event.text}".strip()
                self._bars.update(self._running[event.index], completed=event.fraction or 0.0, note=note)
                if not self.live and time.monotonic() - self._last_line > _PLAIN_PAUSE_S:
                    self._print(f"{self.clock.text()}; now {name} {note}".rstrip())
            case EventKind.NOTICE:
                if event.text not in self._notices:  # what concerns all jobs is said by each
                    self._notices.add(event.text)
                    self._print(f"{name}: {event.text}")
            case EventKind.ENDED:
                if event.index in self._running:  # a job that died at once has not started
                    self._bars.remove_task(self._running.pop(event.index))
                if (result := event.result) is not None and not (result.ok and self.live):
                    state = "done" if result.ok else reason(result)
                    left = f"; {left}" if (left := self.clock.text_left()) else ""
                    count = f"[{len(self.clock.ended)}/{len(self.clock.jobs)}]"
                    self._print(f"{count} {name}: {state} ({duration(result.seconds)}){left}")
            case _:
                assert_never(event.kind)
        self._bars.update(self._all, completed=len(self.clock.ended), note=self.clock.text())

    def _print(self, line: str) -> None:
        self._last_line = time.monotonic()
        self._bars.console.print(line, soft_wrap=True)


class Clock:
    """Counts the jobs and estimates the time left from the expected or the mean time of a job."""

    def __init__(self, jobs: Sequence[Job], workers: int) -> None:
        self.jobs = list(jobs)
        self.workers = max(1, workers)
        self.started: dict[int, float] = {}
        self.fractions: dict[int, float] = {}
        self.ended: dict[int, JobResult] = {}

    def take(self, event: Event) -> None:
        """Count one event of a job."""
        if event.kind is EventKind.STARTED:
            self.started[event.index] = time.monotonic()
        elif event.fraction is not None:
            self.fractions[event.index] = event.fraction
        elif event.result is not None:
            self.ended[event.index] = event.result

    def seconds_left(self) -> float | None:
        """Seconds until the last job ends; None while nothing is known about how long a job takes."""
        mean = self._mean_seconds()
        left = 0.0
        for index, job in enumerate(self.jobs):
            if index in self.ended:
                continue
            spent = time.monotonic() - self.started[index] if index in self.started else 0.0
            fraction = self.fractions.get(index, 0.0)
            whole = spent / fraction if fraction > 0 else job.expected_s if job.expected_s is not None else mean
            if whole is None:
                return None
            left += max(0.0, whole - spent)
        return left / min(self.workers, max(1, len(self.jobs) - len(self.ended)))

    def text(self) -> str:
        """Jobs done, failed, and about how long it will take."""
        failed = sum(not result.ok for result in self.ended.values())
        parts = [f"{len(self.ended)} of {len(self.jobs)} done", f"{failed} failed" if failed else "", self.text_left()]
        return ", ".join(part for part in parts if part)

    def text_left(self) -> str:
        """About how long it will take; "" when that is unknown or nothing is left."""
        stopping = any(result.outcome is JobOutcome.INTERRUPTED for result in self.ended.values())
        left = self.seconds_left() if len(self.ended) < len(self.jobs) and not stopping else None
        return "" if left is None else f"about {duration(left)} left"

    def _mean_seconds(self) -> float | None:
        seconds = [result.seconds for result in self.ended.values() if result.ok]
        seconds += [
            (time.monotonic() - self.started[index]) / fraction
            for index, fraction in self.fractions.items()
            if index not in self.ended and fraction > 0
        ]
        return sum(seconds) / len(seconds) if seconds else None
