"""Many runs: plan them, run what is not there yet, list them under their experiment, and report."""

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace

from repro import cluster
from repro.choices import choices_text
from repro.compose import compose, plan
from repro.errors import UserError
from repro.listing import list_jobs
from repro.overrides import belongs, expand, experiment_of, experiments, setting
from repro.planned import Planned, planned
from repro.tracking.board import Board
from repro.tracking.files import check_writable
from repro.tracking.jobs import Job, JobResult, failure_table
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.pool import run_jobs, start_server
from repro.tracking.stage import Stage
from repro.tracking.store import StageFailed, Store
from repro.tracking.text import duration

# Networks trained for a fraction of their epochs drive the solver to its limits at every step: minutes a loop.
FULLY_TRAINED = ("control_net_size", "sip_control")
CORES = os.cpu_count() or 1
# What takes a job longest to load; the server loads it once, while the jobs are planned.
PRELOAD = ("repro.pipeline", "repro.pipeline_work", "repro.tracking.layout", "rerun.blueprint", "pyarrow.dataset")
EPILOGUE = """examples:
  repro run basis=t1 optimiser=least_squares
  repro run -m basis=t1,t2 objective=forward,inverse
  repro run -m experiment=sip_basis scale=smoke
  repro run --cfg job basis=t2          the resolved configuration, nothing run
  repro run -m --dry-run experiment=sip_energies
  repro run -m experiment=sip_basis hydra/launcher=submitit_slurm hydra.launcher.timeout_min=60
Results lie in outputs/ (or $REPRO_OUTPUTS); a finished run is never repeated.

choices:
"""


def run(argv: Sequence[str]) -> int:
    """`repro run`: one configuration, or with -m all that the lists and the experiment make; 1 when a job failed."""
    options = _run_parser().parse_intermixed_args(argv)
    if options.cfg not in (None, "job"):
        options.overrides.insert(0, options.cfg)  # --cfg basis=t2: what follows is an override
    own, where = cluster.split(options.overrides)
    if where:
        cluster.refuse({"--workers": options.workers, "--timeout": options.timeout}, where)
    overrides = _jobs(own, options.paired, sweep=options.multirun or options.dry_run)
    if options.cfg:
        return _print_configuration(overrides)
    paths = Paths(outputs_root())
    here = not where and not options.dry_run
    jobs = planned(overrides, paths, on_unknown=lambda: start_server(PRELOAD) if here else None)
    if options.failed:
        store = Store(paths.root)
        jobs = [job for job in jobs if job.failures(store)]
    if options.dry_run:
        return _print_plan(jobs)
    list_jobs(paths, jobs)
    results = run_missing(jobs, paths, options.workers or CORES, options.timeout, where)
    _print_outcome(jobs, paths)
    return 1 if any(not result.ok for result in results) else 0


def _jobs(overrides: Sequence[str], paired: bool, sweep: bool) -> list[tuple[str, ...]]:
    """The jobs that a command line asks for; without `sweep` there must be one."""
    if sweep:
        return expand(overrides, paired=paired)
    jobs = expand(overrides, paired=paired, lines=False)
    if experiment_of(jobs[0]) and not setting(jobs[0]) and not belongs(jobs[0]):
        jobs = expand(overrides, paired=paired)
    if len(jobs) > 1:
        raise UserError(f"this makes {len(jobs)} jobs: add -m to run them all, or --dry-run to list them")
    return jobs


def reproduce(argv: Sequence[str]) -> int:
    """`repro reproduce scale=quick`: every experiment, then the report; 1 when a job failed."""
    from repro.report import drawing

    what = f"Run every experiment ({', '.join(FULLY_TRAINED)} by name below scale paper), and make the report."
    example = "example: repro reproduce scale=smoke experiment=sip_basis,sip_energies"
    parser = argparse.ArgumentParser(prog="repro reproduce", description=what, epilog=example)
    parser.add_argument("overrides", nargs="*", help="scale=smoke|quick|paper, experiment=NAME,NAME for some")
    parser.add_argument("--workers", type=int, default=CORES, help="jobs at once")
    options = parser.parse_args(argv)
    given = dict(override.partition("=")[::2] for override in options.overrides)
    if unknown := set(given) - {"scale", "experiment"}:
        raise UserError(f"{', '.join(sorted(unknown))}: reproduce takes scale= and experiment= only; see `repro run`")
    scale = given.get("scale", "quick")
    names = given["experiment"].split(",") if "experiment" in given else experiments_at(scale)
    paths = Paths(outputs_root())
    overrides = [job for name in names for job in expand([f"experiment={name}", f"scale={scale}"])]
    jobs = planned(overrides, paths, on_unknown=lambda: start_server((*PRELOAD, *drawing.PRELOAD)))
    list_jobs(paths, jobs)
    results = run_missing(jobs, paths, options.workers)
    timed = "experiment" in given or _time(paths, scale)
    _report(paths, scale)
    return 0 if timed and all(result.ok for result in results) else 1


def experiments_at(scale: str) -> list[str]:
    """Names of the experiments that are made unasked: all at the paper's scale, below it those that are quick there."""
    return [name for name in experiments() if scale == "paper" or name not in FULLY_TRAINED]


def expected_stages(overrides: Sequence[str]) -> list[Stage]:
    """The stages of a job by the present defaults and code, the run last (for `repro status`)."""
    return Planned.of(compose(overrides, Paths(outputs_root()).composed)).pipeline.stages


def run_missing(
    jobs: Sequence[Planned], paths: Paths, workers: int, timeout: float | None = None, where: Sequence[str] = ()
) -> list[JobResult]:
    """Run the jobs that have no record yet, each once, the longest first; print those that failed."""
    missing = list({job.run: job for job in jobs if job.record is None}.values())
    missing.sort(key=lambda job: -job.expected_seconds)
    if not missing:
        return []
    if not where:
        _check_devices(missing)
    check_writable(paths.root)
    todo = [
        Job(
            name=job.label,
            target="repro.pipeline:run_job",
            arguments={
                "resolved": job.composed.config.model_dump(),
                "outputs": str(paths.root),
                "command": job.composed.command,
                "overrides": job.composed.overrides,
            },
            command=job.composed.command,
            expected_s=job.expected_seconds,
        )
        for job in missing
    ]
    if where:
        ended = cluster.launch([job.arguments for job in todo], where, paths.logs)
        results = [replace(result, job=job) for result, job in zip(ended, todo, strict=True)]
    else:
        with Board(todo, workers) as board:
            results = run_jobs(todo, workers=workers, timeout_s=timeout, preload=PRELOAD, on_progress=board)
    if table := failure_table(results):
        print(table)
    return results


def _check_devices(jobs: Sequence[Planned]) -> None:
    for device in {job.composed.config.device for job in jobs} - {"cpu"}:
        from repro.learning.device.cuda import check_device  # which loads torch

        check_device(device)


def _time(paths: Paths, scale: str) -> bool:
    """Run the benchmark, alone on the machine, so after all jobs; whether it went well."""
    from repro.bench.run import run as bench

    try:
        bench(paths.root, scale)
    except StageFailed as failure:
        print(failure)
        return False
    return True


def _report(paths: Paths, scale: str) -> None:
    from repro.report import build, terminal
    from repro.report.staleness import judged_by_tracking

    terminal.show(build.build(paths.root, scale, stale=judged_by_tracking(paths.root)))


def _print_plan(jobs: Sequence[Planned]) -> int:
    for job in jobs:
        state = "done" if job.record else f"to run, about {duration(job.expected_seconds)}"
        print(f"{job.run}  {state}\n  {job.composed.command}")
    left = sum(job.expected_seconds for job in jobs if job.record is None)
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


def _print_configuration(jobs: Sequence[tuple[str, ...]]) -> int:
    import yaml

    for composed in plan(jobs):
        content = composed.config.model_dump(exclude={"sweep"})
        print(yaml.safe_dump(content, sort_keys=False, default_flow_style=None), end="")
    return 0


def _run_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="repro run",
        description="Run one configuration, or many. Overrides are Hydra's: group=option, group.key=value.",
        epilog=EPILOGUE + choices_text(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("overrides", nargs="*", metavar="key=value")
    parser.add_argument("-m", "--multirun", action="store_true", help="run every combination of the lists")
    parser.add_argument("--paired", action="store_true", help="walk the lists side by side instead of multiplying them")
    parser.add_argument("--dry-run", action="store_true", help="list the jobs, what is done, and the expected time")
    parser.add_argument("--failed", action="store_true", help="only the jobs whose last attempt failed")
    parser.add_argument("--workers", type=int, help=f"jobs at once (default: {CORES}, the cores of this machine)")
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="a job that takes longer is stopped")
    parser.add_argument(
        "--cfg", nargs="?", const="job", metavar="job", help="print the resolved configuration and run nothing"
    )
    return parser
