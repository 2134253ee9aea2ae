"""The words between the launcher of jobs and whoever asked for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Job:
    """One call of `target` ("module:function") with plain keyword arguments, in a process of its own.

    command    the command line that repeats it alone
    expected_s how long it should take; sharpens the time left
    """

    name: str
    target: str
    arguments: dict[str, Any] = field(default_factory=dict)
    command: str = ""
    expected_s: float | None = None


@dataclass(frozen=True)
class JobResult:
    """How a job ended.

    outcome "ok", "failed" (exception), "killed" (no result: signal, os._exit, lack of memory), "timed out",
            "interrupted" (Ctrl-C) or "not started"
    value   what the target returned, when ok
    error   {"type", "message", "trace"}, when not
    log     file with everything the job printed
    """

    job: Job
    outcome: str
    value: Any = None
    error: Mapping[str, Any] | None = None
    seconds: float = 0.0
    log: str = ""

    @property
    def ok(self) -> bool:
        """Whether it returned a value."""
        return self.outcome == "ok"


@dataclass(frozen=True)
class Event:
    """Something that happened to the job at `index` of the list.

    what   "started", "progress", "notice" or "ended"
    """

    what: str
    index: int
    job: Job
    fraction: float | None = None
    text: str = ""
    result: JobResult | None = None


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C ended the sweep; `results` has every job, in order."""

    def __init__(self, results: Sequence[JobResult]) -> None:
        super().__init__("interrupted")
        self.results = list(results)


def failure_table(results: Sequence[JobResult]) -> str:
    """Every job that did not end well: name, what happened, its log and the command that repeats it; "" when none."""
    bad = [result for result in results if result.outcome not in ("ok", "not started", "interrupted")]
    if not bad:
        return ""
    lines = [f"{len(bad)} of {len(results)} jobs failed:"]
    for result in bad:
        lines.append(f"  {result.job.name}: {reason(result)}")
        lines += [f"    log:    {result.log}"] if result.log else []
        lines += [f"    repeat: {result.job.command}"] if result.job.command else []
    return "\n".join(lines)


def reason(result: JobResult) -> str:
    """Why a job did not end well, on one line."""
    error = result.error or {}
    message = str(error.get("message", "")).strip().partition("\n")[0]
    kind = error.get("type", "")
    return ": ".join(part for part in (result.outcome, kind, message) if part)
