"""What a reproduction at the smallest scale runs: enough to try everything, too little to compare anything."""

from collections.abc import Callable, Sequence

from repro.claims.claims import Claim
from repro.config.compose import Overrides
from repro.config.overrides import expand, experiments
from repro.results.selectors import Where
from repro.sweep.planned_job import PlannedJob, plan_jobs
from repro.tracking.paths import Paths

SAMPLED = "smoke"
LIKELY = 4  # jobs of an experiment that are composed first, in search of one that a selector means
BRIEFLY = 2  # jobs of an experiment that this scale leaves out


def plan_sample(
    claims: Sequence[Claim], paths: Paths, on_unknown: Callable[[list[Overrides]], None]
) -> list[PlannedJob]:
    """The first job of every line of the experiments, and a job for each selector of their claims.

    Of an experiment that is reproduced at larger scales alone, the first jobs of its first lines.
    """
    included = experiments(SAMPLED)
    jobs = [job for name in included for job in _jobs(name, first_of_line=True)]
    brief = [job for name in experiments("paper") if name not in included for job in _jobs(name, True)[:BRIEFLY]]
    planned = plan_jobs([*jobs, *brief], paths, on_unknown)
    for claim in claims:
        for where in claim.selectors if claim.experiment in included else ():
            if not any(job.composed.config.experiment == claim.experiment and job.agrees(where) for job in planned):
                planned += _answering(claim.experiment, where, paths)
    return planned


def _answering(experiment: str, where: Where, paths: Paths) -> list[PlannedJob]:
    """A job of an experiment that a selector means; the likely ones are composed first, which takes longest."""
    jobs = sorted(_jobs(experiment), key=lambda job: -sum(f"={value}" in " ".join(job) for value in where.values()))
    for some in (jobs[:LIKELY], jobs[LIKELY:]):
        if found := [job for job in plan_jobs(some, paths) if job.agrees(where)]:
            return found[:1]
    return []


def _jobs(experiment: str, first_of_line: bool = False) -> list[Overrides]:
    return expand([f"experiment={experiment}", f"scale={SAMPLED}"], first_of_line=first_of_line)
