"""Many runs: plan them, run what is not there yet, list them under their experiment, and report."""

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.compose import Composed, plan
from repro.errors import UserError
from repro.overrides import experiments
from repro.pipeline import Pipeline
from repro.tracking.board import Board
from repro.tracking.files import write_json
from repro.tracking.jobs import Job, JobResult, failure_table
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.pool import run_jobs
from repro.tracking.record import Record
from repro.tracking.stage import Stage
from repro.tracking.store import Store
from repro.tracking.text import duration

PRELOAD = ("repro.pipeline", "repro.pipeline_work")
EPILOGUE = """examples:
  repro run basis=t1 optimiser=least_squares
  repro run -m basis=t1,t2 objective=forward,inverse
  repro run -m experiment=sip_basis scale=smoke
  repro run --cfg basis=t2              the resolved configuration, nothing run
  repro run -m --dry-run experiment=sip_energies
  repro run -m +experiment=sip_basis hydra/launcher=submitit_slurm
Results lie in outputs/ (or $REPRO_OUTPUTS); a finished run is never repeated."""


@dataclass(frozen=True)
class Planned:
    """A job with its pipeline, and its record when it is finished already."""

    composed: Composed
    pipeline: Pipeline
    record: Record | None

    @property
    def run(self) -> str:
        """The id that its run has or will have."""
        return self.pipeline.run_stage.id


def run(argv: Sequence[str]) -> int:
    """`repro run`: one configuration, or with -m all that the lists and the experiment make; 1 when a job failed."""
    options = _run_parser().parse_args(argv)
    if options.cfg:
        return _print_configuration(options.overrides)
    paths = Paths(outputs_root())
    jobs = _planned(options.overrides, paths, paired=options.paired)
    if not options.multirun and len(jobs) > 1:
        raise UserError(f"this makes {len(jobs)} jobs: add -m to run them all, or --dry-run to list them")
    if options.failed:
        store = Store(paths.root)
        jobs = [job for job in jobs if store.failure(job.run) or store.failure(job.pipeline.fit_stage.id)]
    if options.dry_run:
        return _print_plan(jobs)
    _list_experiments(paths, jobs)
    results = _run_missing(jobs, paths, options.workers, options.timeout)
    _print_outcome(jobs, paths)
    return 1 if any(not result.ok for result in results) else 0


def reproduce(argv: Sequence[str]) -> int:
    """`repro reproduce scale=quick`: every experiment, then the report; 1 when a job failed."""
    parser = argparse.ArgumentParser(prog="repro reproduce", description="Run every experiment and make the report.")
    parser.add_argument("overrides", nargs="*", help="scale=smoke|quick|paper, experiment=NAME for one alone")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="jobs at once")
    options = parser.parse_args(argv)
    given = dict(override.partition("=")[::2] for override in options.overrides)
    if unknown := set(given) - {"scale", "experiment"}:
        raise UserError(f"{', '.join(sorted(unknown))}: reproduce takes scale= and experiment= only; see `repro run`")
    scale = given.get("scale", "quick")
    names = given["experiment"].split(",") if "experiment" in given else experiments()
    paths = Paths(outputs_root())
    jobs = [job for name in names for job in _planned([f"experiment={name}", f"scale={scale}"], paths)]
    _list_experiments(paths, jobs)
    results = _run_missing(jobs, paths, options.workers, None)
    _report(paths, scale, ran=bool(results))
    return 1 if any(not result.ok for result in results) else 0


def expected_stages(overrides: Sequence[str]) -> list[Stage]:
    """The stages of a job by the present defaults and code, the run last (for `repro status`)."""
    (composed,) = plan(overrides, cache=_cache(Paths(outputs_root())))
    pipeline = Pipeline.of(composed.config, composed.command)
    return [*pipeline.data_stages.values(), pipeline.fit_stage, pipeline.run_stage]


def _planned(overrides: Sequence[str], paths: Paths, paired: bool = False) -> list[Planned]:
    store = Store(paths.root)
    jobs = []
    for composed in plan(overrides, paired=paired, cache=_cache(paths)):
        pipeline = Pipeline.of(composed.config, composed.command)
        jobs.append(Planned(composed, pipeline, pipeline.finished(store)))
    return jobs


def _run_missing(jobs: Sequence[Planned], paths: Paths, workers: int, timeout: float | None) -> list[JobResult]:
    missing = list({job.run: job for job in jobs if job.record is None}.values())
    missing.sort(key=lambda job: -_expected_seconds(job.pipeline))
    if not missing:
        return []
    todo = [
        Job(
            name=_label(job),
            target="repro.pipeline:run_job",
            arguments={
                "resolved": job.composed.config.model_dump(),
                "outputs": str(paths.root),
                "command": job.composed.command,
                "overrides": job.composed.overrides,
            },
            command=job.composed.command,
            expected_s=_expected_seconds(job.pipeline),
        )
        for job in missing
    ]
    with Board(todo, workers) as board:
        results = run_jobs(todo, workers=workers, timeout_s=timeout, preload=PRELOAD, on_progress=board)
    if table := failure_table(results):
        print(table)
    return results


def _list_experiments(paths: Paths, jobs: Sequence[Planned]) -> None:
    """Write what belongs to which experiment before anything runs, so that a missing run is seen as missing."""
    listed: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for job in jobs:
        config = job.composed.config
        if config.experiment is None:
            continue
        entry = {"overrides": list(job.composed.overrides), "run": job.run, "command": job.composed.command}
        listed.setdefault((config.scale.name, config.experiment), []).append(entry)
    for (scale, name), entries in listed.items():
        path = paths.root / "experiments" / scale / f"{name}.json"
        write_json(path, {"experiment": name, "scale": scale, "jobs": entries})


def _report(paths: Paths, scale: str, ran: bool) -> None:
    from repro.report import build, terminal
    from repro.report.staleness import judged_by_tracking

    terminal.show(build.build(paths.root, scale, stale=judged_by_tracking(paths.root)))


def _print_plan(jobs: Sequence[Planned]) -> int:
    for job in jobs:
        state = "done" if job.record else f"to run, about {duration(_expected_seconds(job.pipeline))}"
        print(f"{job.run}  {state}\n  {job.composed.command}")
    left = sum(_expected_seconds(job.pipeline) for job in jobs if job.record is None)
    print(f"{len(jobs)} jobs, {sum(job.record is None for job in jobs)} to run, about {duration(left)} of one core")
    return 0


def _print_outcome(jobs: Sequence[Planned], paths: Paths) -> None:
    store = Store(paths.root)
    for job in jobs:
        record = job.pipeline.finished(store)
        if record is None:
            continue
        shown = {name: record.summary["median"].get(name) for name in ("mae_tau", "mae_qdd", "mae_H_centred")}
        text = ", ".join(f"{name} {value:.3g}" for name, value in shown.items() if value is not None)
        print(f"{record.id}: {text} (medians of {len(job.composed.config.members)} members)")


def _print_configuration(overrides: Sequence[str]) -> int:
    import yaml

    for composed in plan(overrides):
        content = composed.config.model_dump(exclude={"sweep"})
        print(yaml.safe_dump(content, sort_keys=False, default_flow_style=None), end="")
    return 0


def _expected_seconds(pipeline: Pipeline) -> float:
    """A rough guess from what was measured on two cores; it orders the jobs and sharpens the time left."""
    config, optimiser = pipeline.config, pipeline.config.optimiser
    members = len(config.members)
    if config.model["kind"] in ("trivial", "degenerate"):
        return 1.0
    if optimiser["kind"] == "adam":
        units = sum(config.model.get("hidden") or [1])
        samples = getattr(config.data, "samples", 10_000)
        return 2 + members * optimiser["epochs"] * samples * units * 1e-8
    if "iterations" in optimiser:
        phases = 1 + len(config.curriculum.episodes)
        return 3 + members * phases * optimiser["iterations"] * 4e-3
    return 3.0


def _label(job: Planned) -> str:
    return f"{job.pipeline.name} {job.run.rpartition('-')[2][:6]}"


def _cache(paths: Paths) -> Path:
    return paths.root / ".cache" / "composed.json"


def _run_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="repro run",
        description="Run one configuration, or many. Overrides are Hydra's: group=option, group.key=value.",
        epilog=EPILOGUE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("overrides", nargs="*", metavar="key=value")
    parser.add_argument("-m", "--multirun", action="store_true", help="run every combination of the lists")
    parser.add_argument("--paired", action="store_true", help="walk the lists side by side instead of multiplying them")
    parser.add_argument("--dry-run", action="store_true", help="list the jobs, what is done, and the expected time")
    parser.add_argument("--failed", action="store_true", help="only the jobs whose last attempt failed")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="jobs at once")
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="a job that takes longer is stopped")
    parser.add_argument("--cfg", action="store_true", help="print the resolved configuration and run nothing")
    return parser
