"""The jobs of a sweep on one of Hydra's launchers: submitit (SLURM, or local processes) and Ray.

Hydra sweeps over the jobs' numbers; each job is read from a file by its number, runs in a process of its own, leaves
its result in the store and its outcome beside its log. The store must lie on a file system that all machines share.
"""

import importlib
import importlib.util
import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from repro.errors import UserError
from repro.launch.jobs import Event, EventKind, Job, JobOutcome, JobResult, reason
from repro.launch.pool import run_jobs
from repro.tracking.files import write_json

LAUNCHER = "hydra/launcher="
EXTRAS = {
    "submitit_slurm": ("slurm", "hydra_plugins.hydra_submitit_launcher"),
    "submitit_local": ("slurm", "hydra_plugins.hydra_submitit_launcher"),
    "ray": ("ray", "hydra_plugins.hydra_ray_launcher"),
}
# By launcher: the setting that takes the place of a flag for one machine.
INSTEAD = {
    "submitit_slurm": {"--workers": "hydra.launcher.array_parallelism=N", "--timeout": "hydra.launcher.timeout_min=N"},
    "submitit_local": {"--timeout": "hydra.launcher.timeout_min=N"},
    "ray": {"--workers": "+hydra.launcher.ray.init.num_cpus=N"},
}
_SUBMITTED = "_submitted.pkl"
JOBS, ENDED = "jobs.json", "ended.json"  # in the folder of the sweep, and in one per job


def split(overrides: Sequence[str]) -> tuple[list[str], list[str]]:
    """The overrides that make the jobs, and those that choose and set the launcher.

    Without `hydra/launcher=...` all of them make jobs, which run on this machine. Raises UserError for a launcher that
    does not exist or is not installed.
    """
    names = [override.removeprefix(LAUNCHER) for override in overrides if override.startswith(LAUNCHER)]
    if not names:
        return list(overrides), []
    jobs = [override for override in overrides if not override.lstrip("+").startswith("hydra")]
    for name in names:
        if name not in EXTRAS:
            raise UserError(f"{LAUNCHER}{name}: allowed are {', '.join(EXTRAS)}; leave it out to run on this machine")
        extra, plugin = EXTRAS[name]
        if not _is_installed(plugin):
            raise UserError(f"{LAUNCHER}{name} needs an extra: pip install -e '.[{extra}]' in the project's folder")
    return jobs, [override for override in overrides if override not in jobs]


def refuse(flags: Mapping[str, float | None], launcher: Sequence[str]) -> None:
    """Raise UserError for a flag that applies to one machine only, since the jobs run on a launcher."""
    name = next(override.removeprefix(LAUNCHER) for override in launcher if override.startswith(LAUNCHER))
    for flag, value in flags.items():
        if value is not None:
            setting = INSTEAD[name].get(flag)
            advice = f"set {setting} instead" if setting else "this launcher has no such setting"
            raise UserError(f"{flag} is for jobs on this machine, not for {LAUNCHER}{name}; leave it out: {advice}")


def launch(jobs: Sequence[Job], launcher: Sequence[str], logs: Path) -> list[JobResult]:
    """Run the jobs on a launcher and wait; returns how each ended, in their order."""
    from hydra.core.override_parser.types import Quote, QuotedString  # takes longer to load than most commands need

    folder = logs / f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    write_json(folder / JOBS, [asdict(job) for job in jobs])
    place = QuotedString(str(folder), Quote.single).with_quotes()
    sweep = [f"+folder={place}", f"hydra.sweep.dir={place}", f"+job=range({len(jobs)})"]
    quiet = ["hydra.job.name=repro", "hydra.output_subdir=null", "hydra.job.chdir=false"]
    print(f"{len(jobs)} jobs on {' '.join(launcher)}; their logs: {folder}", file=sys.stderr, flush=True)
    subprocess.run([sys.executable, "-m", __name__, str(folder), "-m", *quiet, *launcher, *sweep], check=False)
    return [_ending(folder, number, job) for number, job in enumerate(jobs)]


def _ending(folder: Path, number: int, job: Job) -> JobResult:
    try:
        return TypeAdapter(JobResult).validate_json((folder / str(number) / ENDED).read_bytes())
    except FileNotFoundError:
        message = "the scheduler stopped it, or never started it: see the messages above and the logs"
        return JobResult(job, JobOutcome.KILLED, error=message, log=str(folder))


def _is_installed(plugin: str) -> bool:
    try:
        return importlib.util.find_spec(plugin) is not None
    except ModuleNotFoundError:
        return False


def _run_one(config: Any) -> None:
    """Run one job on the machine that the launcher chose.

    Raises nothing, whatever the job does: Hydra's launchers give up a whole sweep for one failed job.
    """
    folder, number = Path(config.folder), config.job
    job = Job(**json.loads((folder / JOBS).read_bytes())[number])
    print(job.command, flush=True)
    file = folder / str(number) / ENDED

    def print_notice(event: Event) -> None:
        if event.kind is EventKind.NOTICE:
            print(event.text, flush=True)

    try:
        [result] = run_jobs([job], workers=1, preload=(), on_progress=print_notice, logs=file.parent)
    except Exception as error:  # submitit's signal handler raises when the time is over
        result = JobResult(job, JobOutcome.KILLED, error=f"{type(error).__name__}: {error}")
    print(reason(result), result.log, flush=True)
    write_json(file, asdict(replace(result, value=None)))  # what a job returns need not be plain data


def _drive() -> None:
    """Hydra's multi-run over the jobs; its arguments follow the folder of the sweep."""
    import hydra

    folder = Path(sys.argv.pop(1))
    try:
        hydra.main(version_base="1.3", config_path=None)(_run_one)()
    except KeyboardInterrupt:
        sys.exit(130)
    except (Exception, SystemExit):
        _wait_for_other_jobs(folder)
        raise


def _wait_for_other_jobs(folder: Path) -> None:
    """Submitit's launchers stop waiting once the scheduler has killed a job, while the other jobs still run."""
    if f"{LAUNCHER}submitit_local" in sys.argv:
        with suppress(ChildProcessError):
            while True:
                os.wait()  # its jobs are children of this process
    if f"{LAUNCHER}submitit_slurm" in sys.argv:
        slurm_job = importlib.import_module("submitit").SlurmJob
        for file in folder.glob(f".submitit/*/*{_SUBMITTED}"):
            slurm_job(file.parent, file.name.removesuffix(_SUBMITTED)).wait()


if __name__ == "__main__":
    _drive()
