"""`repro reproduce`: every experiment, then the report."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from repro.commands.arguments import command_parser
from repro.errors import UserError

if TYPE_CHECKING:
    from repro.tracking.paths import Paths

HELP = "run every experiment and make the report"
EXAMPLE = "scale=quick"
# Networks trained for a fraction of their epochs drive the solver to its limits at every step: minutes a loop.
FULLY_TRAINED = ("control_net_size", "sip_control")


def main(argv: Sequence[str]) -> int:
    """Run every experiment, then make the report; 1 when a job failed."""
    from repro.config.overrides import expand
    from repro.launch.pool import start_server
    from repro.report import drawing
    from repro.sweep.listing import list_jobs
    from repro.sweep.missing import CORES, PRELOAD, run_missing
    from repro.sweep.planned_job import planned
    from repro.tracking.paths import Paths, outputs_root

    what = f"Run every experiment ({', '.join(FULLY_TRAINED)} by name below scale paper), and make the report."
    example = "example: repro reproduce scale=smoke experiment=sip_basis,sip_energies"
    parser = command_parser("reproduce", what, example)
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
    """Names of the experiments that run by default: all at the paper's scale, below it those that are quick there."""
    from repro.config.overrides import experiments

    return [name for name in experiments() if scale == "paper" or name not in FULLY_TRAINED]


def _time(paths: "Paths", scale: str) -> bool:
    """Run the benchmark, alone on the machine, so after all jobs; whether it went well."""
    from repro.bench.stored_bench import run as bench
    from repro.tracking.store import StageFailed

    try:
        bench(paths.root, scale)
    except StageFailed as failure:
        print(failure)
        return False
    return True


def _report(paths: "Paths", scale: str) -> None:
    from repro.report import build, terminal
    from repro.results.staleness import judged_by_tracking

    terminal.show(build.build(paths.root, scale, stale=judged_by_tracking(paths.root)))
