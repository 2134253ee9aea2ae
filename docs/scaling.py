"""Simulates the published experiments on more cores, from their stored stages, and writes docs/scale-out.md.

python docs/scaling.py           write the numbers again, from paper/results/stages.parquet
python docs/scaling.py --check   exit with 1 when they are out of date
"""

import heapq
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import pandas as pd
from generated import write_or_check

from repro.config.overrides import experiments
from repro.launch.machine import SHARE

ROOT = Path(__file__).resolve().parents[1]
STAGES, RUNS = (ROOT / "paper" / "results" / f"{table}.parquet" for table in ("stages", "runs"))
PAGE = ROOT / "docs" / "scale-out.md"
CORES = (2, 8, 16, 64)
MIB_A_CORE = 4096


@dataclass(frozen=True)
class Stage:
    """A stage by its id, which several jobs may share; seconds: on one core."""

    id: str
    seconds: float


@dataclass(frozen=True)
class Job:
    """The process that makes a run: its stages one after another, and the most memory that one of them took."""

    stages: Sequence[Stage]
    mib: float

    @property
    def seconds(self) -> float:
        """All its stages."""
        return sum(stage.seconds for stage in self.stages)


@dataclass(frozen=True)
class Schedule:
    """Seconds until the last job ends, and the largest sum of the memory of jobs that run at once."""

    seconds: float
    mib: float


def simulated(jobs: Sequence[Job], cores: int, memory_mib: float) -> Schedule:
    """The list schedule of `repro`: the longest job first, and the next that there is a core and memory for.

    A stage that several jobs share is made by the first of them; the others keep their core and wait. One job is
    started whatever it takes.
    """
    waiting = sorted(range(len(jobs)), key=lambda number: -jobs[number].seconds)
    ends: dict[str, float] = {}  # of every stage that was begun
    events: list[tuple[float, int, int]] = []  # when a job goes on, the job, and its stage
    running: set[int] = set()
    now = peak = 0.0
    while waiting or events:
        while waiting and len(running) < cores:
            taken = sum(jobs[number].mib for number in running)
            fitting = (number for number in waiting if not running or jobs[number].mib <= memory_mib - taken)
            if (chosen := next(fitting, None)) is None:
                break
            waiting.remove(chosen)
            running.add(chosen)
            peak = max(peak, taken + jobs[chosen].mib)
            heapq.heappush(events, (now, chosen, 0))
        now, number, position = heapq.heappop(events)
        if position == len(jobs[number].stages):
            running.remove(number)
            continue
        stage = jobs[number].stages[position]
        end = ends.setdefault(stage.id, now + stage.seconds)
        heapq.heappush(events, (max(now, end), number, position + 1))
    return Schedule(now, peak)


def jobs_of(stages: pd.DataFrame, cost: str) -> list[Job]:
    """The jobs behind a table of stages, upstream first; cost: the column of their seconds."""
    return [
        Job([Stage(*pair) for pair in zip(run["id"], run[cost], strict=True)], run["peak_memory_mib"].max())
        for _, run in stages.groupby("run", sort=False)
    ]


def busy_seconds(stages: pd.DataFrame) -> float:
    """Seconds in which at least one stage was made."""
    begun = [datetime.fromisoformat(started).timestamp() for started in stages["started"]]
    total = reached = 0.0
    for begin, seconds in sorted(zip(begun, stages["wall_s"], strict=True)):
        total += max(0.0, begin + seconds - max(begin, reached))
        reached = max(reached, begin + seconds)
    return total


def numbers(stages: pd.DataFrame, others: pd.DataFrame) -> str:
    """The lines of the page, of what `repro reproduce` makes; others: the stages of what is run by its name alone."""
    distinct, jobs = stages.drop_duplicates("id"), jobs_of(stages, "cpu_s")
    total, longest, used = distinct["cpu_s"].sum(), max(job.seconds for job in jobs), int(stages["cores"].max())
    rows = []
    for cores in CORES:
        schedule = simulated(jobs, cores, SHARE * MIB_A_CORE * cores)
        cells = _minutes(schedule.seconds), _minutes(total / cores), f"{schedule.mib / 1024:.1f}"
        rows.append(f"| {cores} | {' | '.join(cells)} |\n")
    named = others[~others["id"].isin(distinct["id"])].drop_duplicates("id")
    again = _minutes(simulated(jobs_of(stages, "wall_s"), used, math.inf).seconds)
    return f"""\
{len(jobs)} runs with {len(distinct)} distinct stages take {_minutes(total)} min of one core. The longest run takes
{_minutes(longest)} min, a bound that more cores do not lower.

| cores | simulated, min | work / cores, min | most memory at once, GiB |
| --- | --- | --- | --- |
{"".join(rows)}
The check: from the elapsed time of the same stages the simulation of {used} cores gives {again} min; the {used} cores
that made them were at work for {_minutes(busy_seconds(distinct))} min.

Not in the table: {others["run"].nunique()} runs of experiments that are run by their names alone, which take
{_minutes(named["cpu_s"].sum())} min of one core.
"""


def _minutes(seconds: float) -> str:
    return f"{seconds / 60:.1f}"


def main(arguments: Sequence[str]) -> int:
    """Write the page, or check it."""
    columns = ["run", "id", "started", "wall_s", "cpu_s", "peak_memory_mib", "cores"]
    stages, runs = pd.read_parquet(STAGES, columns=columns), pd.read_parquet(RUNS, columns=["run", "experiment"])
    included = stages["run"].isin(runs.loc[runs["experiment"].isin(experiments("paper")), "run"])
    return write_or_check(PAGE, "scaling", numbers(stages[included], stages[~included]), arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
