"""`repro reproduce`: every experiment, then the report."""

from argparse import Namespace
from collections.abc import Sequence

from repro.claims.claims import load_claims
from repro.config.compose import Overrides
from repro.config.overrides import expand, experiments
from repro.errors import UserError
from repro.launch import own_progress
from repro.launch.jobs import Job
from repro.launch.pool import start_server
from repro.plugins.roots import plugin_roots
from repro.report import drawing
from repro.sweep.listing import list_jobs
from repro.sweep.missing import preload, run_missing
from repro.sweep.planned_job import SAMPLED, plan_jobs, plan_sample
from repro.tracking.paths import Paths, outputs_root, project_folder
from repro.tracking.store import StageFailed

BENCH_S, BENCH_MIB = 15.0, 700.0  # at the smallest scale


def main(arguments: Namespace) -> int:
    """Run every experiment, then make the report; 1 when a job failed."""
    chosen = dict(override.partition("=")[::2] for override in arguments.overrides)
    if unknown := set(chosen) - {"scale", "experiment"}:
        raise UserError(f"{', '.join(sorted(unknown))}: reproduce takes scale= and experiment= only; see `repro run`")
    scale = chosen.get("scale", "quick")
    paths = Paths(outputs_root())
    own = project_folder() in plugin_roots()  # of the user: its report has no timings of this project
    if "experiment" not in chosen and scale == SAMPLED and not own:
        jobs = plan_sample(load_claims(project_folder() / "paper" / "claims.yaml"), paths, _start)
    else:
        names = chosen["experiment"].split(",") if "experiment" in chosen else experiments(scale)
        overrides = [job for name in names for job in expand([f"experiment={name}", f"scale={scale}"])]
        jobs = plan_jobs(overrides, paths, _start)
    list_jobs(paths, jobs)
    untimed = own or "experiment" in chosen
    # The smallest scale shows that timings can be made, not what they are: they need not be alone on the machine.
    beside = [_timings(paths, scale)] if scale == SAMPLED and not untimed else []
    results = run_missing(jobs, paths, arguments.workers, first=beside)
    timed = untimed or (beside and results) or _time(paths, scale)
    from repro.report import build, terminal  # after the runs: their start must not wait for it
    from repro.results.stored import stale_runs

    with own_progress.shown("report"):
        summary = build.build(paths.root, scale, stale=stale_runs(paths.root))
    terminal.show(summary)
    return 0 if timed and all(result.ok for result in results) else 1


def _start(jobs: Sequence[Overrides]) -> None:
    start_server((*preload(jobs), *drawing.PRELOAD))


def _timings(paths: Paths, scale: str) -> Job:
    """The benchmark as a job."""
    arguments = {"outputs": str(paths.root), "scale": scale}
    command = f"repro bench --scale {scale}"
    return Job("timings", "repro.bench.stored_bench:run", arguments, command, BENCH_S, BENCH_MIB)


def _time(paths: Paths, scale: str) -> bool:
    """Run the benchmark, alone on the machine, so after all jobs; whether it went well."""
    from repro.bench.stored_bench import run as bench

    try:
        bench(paths.root, scale)
    except StageFailed as failure:
        print(failure)
        return False
    return True
