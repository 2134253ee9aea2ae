"""The jobs of a sweep on one of Hydra's launchers: submitit (SLURM, or local processes) and Ray.

Hydra sweeps over the jobs' numbers; each looks its number up in a file, runs in a process of its own, leaves its result
in the store, and how it ended beside its log. The store must lie where all machines see it.
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
from dataclasses import asdict
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.launch.jobs import Event, Job, JobResult, reason
from repro.launch.pool import run_jobs
from repro.tracking.files import write_json
from repro.tracking.text import hydra_quoted

LAUNCHER = "hydra/launcher="
EXTRAS = {
    "submitit_slurm": ("slurm", "hydra_plugins.hydra_submitit_launcher"),
    "submitit_local": ("slurm", "hydra_plugins.hydra_submitit_launcher"),
    "ray": ("ray", "hydra_plugins.hydra_ray_launcher"),
}
# What stands on a launcher for a flag that is for one machine.
INSTEAD = {
    "submitit_slurm": {"--workers": "hydra.launcher.array_parallelism=N", "--timeout": "hydra.launcher.timeout_min=N"},
    "submitit_local": {"--timeout": "hydra.launcher.timeout_min=N"},
    "ray": {"--workers": "+hydra.launcher.ray.init.num_cpus=N"},
}
_SUBMITTED = "_submitted.pkl"


def split(overrides: Sequence[str]) -> tuple[list[str], list[str]]:
    """The overrides that make the jobs, and those that say where they run; UserError for a launcher that is not there.

    Without `hydra/launcher=...` the second list is empty: the jobs run on this machine.
    """
    jobs = [override for override in overrides if not override.lstrip("+").startswith("hydra")]
    where = [override for override in overrides if override not in jobs]
    names = [override.removeprefix(LAUNCHER) for override in where if override.startswith(LAUNCHER)]
    if where and not names:
        raise UserError(f"{where[0]}: settings of Hydra itself go with hydra/launcher={'|'.join(EXTRAS)}")
    for name in names:
        if name not in EXTRAS:
            raise UserError(f"{LAUNCHER}{name}: allowed are {', '.join(EXTRAS)}; leave it out to run on this machine")
        extra, plugin = EXTRAS[name]
        if not _is_there(plugin):
            raise UserError(f"{LAUNCHER}{name} needs an extra: pip install -e '.[{extra}]' in the project's folder")
    return jobs, where


def refuse(flags: Mapping[str, float | None], where: Sequence[str]) -> None:
    """UserError for a flag with a value that is for one machine, when the jobs run on a launcher."""
    name = next(override.removeprefix(LAUNCHER) for override in where if override.startswith(LAUNCHER))
    for flag, value in flags.items():
        if value is not None:
            setting = INSTEAD[name].get(flag)
            advice = f"set {setting} instead" if setting else "this launcher has no such setting"
            raise UserError(f"{flag} is for jobs on this machine, not for {LAUNCHER}{name}; leave it out: {advice}")


def launch(jobs: Sequence[Job], where: Sequence[str], logs: Path) -> list[JobResult]:
    """Run the jobs on a launcher and wait; returns how each ended, in their order."""
    folder = logs / f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    write_json(_jobs_file(folder), [asdict(job) for job in jobs])
    told = [f"+folder={hydra_quoted(folder)}", f"hydra.sweep.dir={hydra_quoted(folder)}", f"+job=range({len(jobs)})"]
    quiet = ["hydra.job.name=repro", "hydra.output_subdir=null", "hydra.job.chdir=false"]
    print(f"{len(jobs)} jobs on {' '.join(where)}; their logs: {folder}", file=sys.stderr, flush=True)
    subprocess.run([sys.executable, "-m", __name__, str(folder), "-m", *quiet, *where, *told], check=False)
    return [_ending(folder, number, job) for number, job in enumerate(jobs)]


def _jobs_file(folder: Path) -> Path:
    return folder / "jobs.json"


def _ending_file(folder: Path, number: int) -> Path:
    return folder / str(number) / "ended.json"


def _ending(folder: Path, number: int, job: Job) -> JobResult:
    try:
        return JobResult(job, **json.loads(_ending_file(folder, number).read_bytes()))
    except FileNotFoundError:
        message = "the scheduler stopped it, or never started it: see the messages above and the logs"
        return JobResult(job, "killed", error={"message": message}, log=str(folder))


def _is_there(plugin: str) -> bool:
    try:
        return importlib.util.find_spec(plugin) is not None
    except ModuleNotFoundError:
        return False


def _run_one(config: Any) -> None:
    """One job, on the machine that the launcher chose.

    Whatever happens in its process, this one ends well: Hydra's launchers give up a whole sweep for one failed job.
    """
    folder, number = Path(config.folder), config.job
    job = Job(**json.loads(_jobs_file(folder).read_bytes())[number])
    print(job.command, flush=True)
    own = _ending_file(folder, number)
    try:
        [result] = run_jobs([job], workers=1, preload=(), on_progress=_print_notice, logs=own.parent)
    except Exception as error:  # submitit's word, raised by its signal handler, that the time is over
        result = JobResult(job, "killed", error={"type": type(error).__name__, "message": str(error)})
    print(reason(result), result.log, flush=True)
    write_json(own, {"outcome": result.outcome, "error": result.error, "seconds": result.seconds, "log": result.log})


def _print_notice(event: Event) -> None:
    if event.what == "notice":
        print(event.text, flush=True)


def _drive() -> None:
    """Hydra's multi-run over the jobs; its arguments follow the folder of the sweep."""
    import hydra

    folder = Path(sys.argv.pop(1))
    try:
        hydra.main(version_base="1.3", config_path=None)(_run_one)()
    except KeyboardInterrupt:
        sys.exit(130)
    except (Exception, SystemExit):
        _wait_for_the_others(folder)
        raise


def _wait_for_the_others(folder: Path) -> None:
    """Submitit's launchers listen no more once the scheduler has killed a job; the others still run."""
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
