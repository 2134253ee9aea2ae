"""The jobs of a sweep on one of Hydra's launchers: submitit (SLURM, or local processes) and Ray.

Hydra sweeps over the jobs' numbers; each looks its number up in a file, runs, and leaves its result in the store, which
tells afterwards what became of it. The store must lie where all machines see it.
"""

import importlib.util
import json
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking.files import write_json

LAUNCHER = "hydra/launcher="
EXTRAS = {
    "submitit_slurm": ("slurm", "hydra_plugins.hydra_submitit_launcher"),
    "submitit_local": ("slurm", "hydra_plugins.hydra_submitit_launcher"),
    "ray": ("ray", "hydra_plugins.hydra_ray_launcher"),
}


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
            raise UserError(f"{LAUNCHER}{name} needs an extra: pip install 'repro[{extra}]'")
    return jobs, where


def launch(jobs: Sequence[dict[str, Any]], where: Sequence[str], logs: Path) -> None:
    """Run the jobs (arguments of `pipeline.run_job`) on a launcher and wait; what became of them is in the store."""
    folder = logs / f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    write_json(folder / "jobs.json", list(jobs))
    told = [f"+jobs={folder / 'jobs.json'}", f"+job=range({len(jobs)})", f"hydra.sweep.dir={folder}"]
    quiet = ["hydra.output_subdir=null", "hydra.job.chdir=false"]
    print(f"{len(jobs)} jobs on {' '.join(where)}; their logs: {folder}", file=sys.stderr, flush=True)
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    command = [sys.executable, "-m", __name__, "-m", *where, *told, *quiet]
    subprocess.run(command, env={**one_thread, **os.environ}, check=False)


def _is_there(plugin: str) -> bool:
    try:
        return importlib.util.find_spec(plugin) is not None
    except ModuleNotFoundError:
        return False


def _run_one(config: Any) -> None:
    from repro.pipeline import run_job

    arguments = json.loads(Path(config.jobs).read_bytes())[config.job]
    print(arguments["command"], flush=True)
    try:
        run_job(**arguments)
    except Exception:
        # A job that fails costs no other: the store keeps why, and the launcher sees a job that has ended.
        traceback.print_exc()


if __name__ == "__main__":
    import hydra

    hydra.main(version_base="1.3", config_path=None)(_run_one)()
