"""Runs those of many planned jobs that are not there yet."""

import sys
from collections.abc import Iterable, Sequence

from repro.config.compose import compose
from repro.config.registry import settings
from repro.launch import cluster
from repro.launch.jobs import Job, JobResult, failure_table
from repro.launch.machine import allowed_cores
from repro.launch.pool import run_jobs
from repro.learning.optimiser_options import OPTIMISERS
from repro.models.model_options import MODELS
from repro.plugins.plugin import plugin
from repro.sweep.planned_job import PlannedJob, total
from repro.tracking.files import check_writable
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.stage import Stage

RUN_JOB = "repro.pipeline.run:run_job"
_STAGES = ("data", "fit", "evaluate", "close_loops")
_PRELOAD = (
    *("repro.pipeline.run", *(f"repro.pipeline.stages.{stage}" for stage in _STAGES), "repro.pipeline.read_ahead"),
    *("repro.recording.layout", "rerun.blueprint", "pyarrow.dataset"),
)
_MANY = 10  # jobs, some of which will need what a single one seldom does
_PRELOAD_OF_MANY = ("scipy.optimize", "hydra")


def expected_stages(overrides: Sequence[str]) -> list[Stage]:
    """The stages of a job by the present defaults and code, the run last (for `repro status`)."""
    return PlannedJob.of(compose(overrides, Paths(outputs_root()).composed)).pipeline.stages


def preload(jobs: Iterable[Sequence[str]]) -> tuple[str, ...]:
    """The modules that the jobs (the overrides of each) load longest, for the server of processes to load once.

    torch, the longest of all, only where a job may need it.
    """
    jobs = list(jobs)
    modules = _PRELOAD if len(jobs) < _MANY else (*_PRELOAD, *_PRELOAD_OF_MANY)
    return modules if all(map(_is_closed_form, jobs)) else (*modules, "torch", "repro.learning.optimisers.adam")


def _is_closed_form(job: Sequence[str]) -> bool:
    """Whether a job chooses a model without weights, or an optimiser that solves a linear problem."""
    chosen = dict(override.split("=", 1) for override in job if override.startswith(("model=", "optimiser=")))
    kinds = {group: settings(group, option)["kind"] for group, option in chosen.items()}
    anchor = "model" in kinds and not plugin(MODELS, kinds["model"]).Options.fitted
    return anchor or ("optimiser" in kinds and plugin(OPTIMISERS, kinds["optimiser"]).Options.linear_only)


def run_missing(
    jobs: Sequence[PlannedJob],
    paths: Paths,
    workers: int | None = None,
    timeout: float | None = None,
    where: Sequence[str] = (),
    first: Sequence[Job] = (),
) -> list[JobResult]:
    """Run the jobs that have no record yet, each once, the longest first; print those that failed.

    workers  jobs at once, None for one per allowed core
    timeout  seconds after which a job is stopped
    where    the overrides of a Hydra launcher that runs them elsewhere
    first    other work, begun before them where there are any
    """
    missing = list({job.run: job for job in jobs if job.record is None}.values())
    missing.sort(key=lambda job: -job.expected_seconds)
    if not missing:
        return []
    for device in {job.composed.config.device for job in missing} - {"cpu"} if not where else ():
        from repro.learning.device.cuda import check_device  # which loads torch

        check_device(device)
    check_writable(paths.root)
    print(total(jobs), file=sys.stderr, flush=True)
    todo = [
        *first,
        *(
            Job(
                name=job.label,
                target=RUN_JOB,
                arguments={
                    "resolved": job.composed.config.model_dump(mode="json"),
                    "outputs": str(paths.root),
                    "command": job.composed.command,
                    "overrides": job.composed.overrides,
                },
                command=job.composed.command,
                expected_s=job.expected_seconds,
                expected_mib=job.expected_mib,
            )
            for job in missing
        ),
    ]
    if where:
        results = cluster.launch(todo, where, paths.logs)
    else:
        from repro.launch.board import Board  # loads longer than what comes before it

        workers = workers or allowed_cores()
        modules = preload(job.composed.overrides for job in missing)
        with Board(todo, workers) as board:
            results = run_jobs(todo, workers=workers, timeout_s=timeout, preload=modules, on_progress=board)
    if table := failure_table(results):
        print(table)
    return results
