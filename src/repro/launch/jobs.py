"""Data types shared by the job launcher and its callers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


@dataclass(frozen=True)
class Job:
    """One call of `target` ("module:function") with plain keyword arguments, in a process of its own."""

    name: str
    target: str
    arguments: Mapping[str, object] = field(default_factory=dict)
    command: str = ""  # the command line that repeats it alone
    expected_s: float | None = None  # how long it should take, for a better estimate of the time left
    expected_mib: float = 0.0  # memory that it should take at most: as many jobs run at once as there is memory for


class JobOutcome(StrEnum):
    """How a job ended; KILLED is the end without a result: a signal, os._exit, lack of memory."""

    OK = "ok"
    FAILED = "failed"
    KILLED = "killed"
    TIMED_OUT = "timed out"
    INTERRUPTED = "interrupted"
    NOT_STARTED = "not started"


@dataclass(frozen=True)
class JobResult:
    """The end of a job.

    error  why it did not end well, after the name of the exception unless the user can fix it; trace: of the exception
    """

    job: Job
    outcome: JobOutcome
    value: Any = None  # what the target returned, when OK
    error: str = ""
    trace: str = ""
    seconds: float = 0.0
    log: str = ""  # file with everything the job printed

    @property
    def ok(self) -> bool:
        """Whether it returned a value."""
        return self.outcome is JobOutcome.OK


class EventKind(StrEnum):
    """What happened to a job."""

    STARTED = "started"
    PROGRESS = "progress"
    NOTICE = "notice"
    ENDED = "ended"


@dataclass(frozen=True)
class Event:
    """Something that happened to the job at `index` of the list."""

    kind: EventKind
    index: int
    fraction: float | None = None  # finished part of the job (0 to 1), None when unknown
    text: str = ""  # what the job is doing, or its notice
    result: JobResult | None = None  # only when it has ENDED


def failure_table(results: Sequence[JobResult]) -> str:
    """Every job that failed: name, what happened, its log and the command that repeats it; "" when there are none."""
    harmless = (JobOutcome.OK, JobOutcome.NOT_STARTED, JobOutcome.INTERRUPTED)
    bad = [result for result in results if result.outcome not in harmless]
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
    message = result.error.strip().partition("\n")[0]
    return f"{result.outcome}: {message}" if message else str(result.outcome)
