"""Where a result comes from: source, machine, libraries, seeds, time and memory."""

import hashlib
import os
import platform
import re
import resource
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from repro.tracking.files import file_digest, write_bytes
from repro.tracking.plain_data import flattened
from repro.tracking.record import Provenance
from repro.tracking.stage import Stage

# The files that a run's identity is made from: of new files these alone are stored.
_READ_BY_RUNS = re.compile(r"src/repro/.*\.(py|c|h)|(conf|experiments)/.*\.yaml")
_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Meter:
    """Measures one stage from here on: wall time, and processor time of this process and its children."""

    def __init__(self) -> None:
        self.started_at = datetime.now(UTC)
        self._start = time.perf_counter(), _processor_seconds()

    def seconds(self) -> tuple[float, float]:
        """Wall and processor seconds since the start."""
        wall, processor = self._start
        return round(time.perf_counter() - wall, 4), round(_processor_seconds() - processor, 4)


def describe(stage: Stage, overrides: Sequence[str], patches: Path, meter: Meter) -> Provenance:
    """Provenance of a stage that ends now; what cannot change within a process is looked up once."""
    wall_s, cpu_s = meter.seconds()
    config = flattened(stage.identity.config).items()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return Provenance(
        command=stage.command,
        overrides=tuple(overrides),
        seeds={key: value for key, value in config if key.rpartition(".")[2] in ("seed", "seeds")},
        started=meter.started_at.isoformat(timespec="milliseconds"),
        finished=datetime.now(UTC).isoformat(timespec="milliseconds"),
        wall_s=wall_s,
        cpu_s=cpu_s,
        peak_memory_mib=round(peak / (1024 if sys.platform != "darwin" else 1024**2), 1),
        git=_source(patches),
        machine=_machine(),
        threads=_threads(),
        torch=_torch(),
        upstream=dict(stage.upstream),
    )


def look_up() -> None:
    """Look up what does not change while jobs run, for processes that are forked from this one."""
    source_tree()
    _machine()


@cache
def _source(patches: Path) -> dict[str, Any]:
    top = source_tree()
    pins = top / "constraints.txt" if top else None
    sha256 = file_digest(pins) if pins and pins.is_file() else None
    return {**source_state(patches), "constraints_sha256": sha256}


@cache
def source_tree() -> Path | None:
    """Top folder of the git checkout this package runs from; None for an installed copy or without git."""
    here = Path(__file__).resolve()
    try:
        _git(here.parent, "ls-files", "--error-unmatch", here.name)
        return Path(_git(here.parent, "rev-parse", "--show-toplevel").strip()).resolve()
    except (subprocess.CalledProcessError, OSError):
        return None


def source_state(patches: Path) -> dict[str, Any]:
    """Commit, branch, clean or not, and the patch (uncommitted changes and new source files) that `git apply` takes.

    The patch is stored once per content as <patches>/<hash>.patch. Of new files that no run is made from (data, .env)
    the names are stored, never the content.
    """
    top = source_tree()
    if top is None:
        return {"commit": None, "why": "the package does not run from a git checkout"}
    try:
        status = _git(top, "status", "--porcelain=v2", "--branch", "--untracked-files=all", "-z").split("\0")
        header = dict(line[2:].split(" ", 1) for line in status if line.startswith("# "))
        untracked = [line[2:] for line in status if line.startswith("? ")]
        if top in (results := patches.parent.resolve()).parents:
            untracked = [name for name in untracked if not (top / name).is_relative_to(results)]
        clean = not untracked and not any(line and line[0] in "12u" for line in status)
        state = {"commit": header.get("branch.oid"), "branch": header.get("branch.head"), "clean": clean, "patch": None}
        if clean:
            return state
        source = [name for name in untracked if _READ_BY_RUNS.fullmatch(name)]
        patch = os.fsencode(_patch(top, source))
    except subprocess.CalledProcessError as error:
        return {"commit": None, "why": f"git {error.cmd[3]} failed: {os.fsdecode(error.stderr).strip()}"}
    file = patches / f"{hashlib.sha256(patch).hexdigest()[:16]}.patch"
    if not file.exists():
        write_bytes(file, patch)
    others = sorted(set(untracked) - set(source))
    return state | {"patch": f"{patches.name}/{file.name}", "untracked": source, "untracked_not_stored": others}


def _patch(top: Path, new_files: list[str]) -> str:
    with tempfile.TemporaryDirectory() as folder:
        # A copy of git's list of files, so that naming the new ones leaves the user's own list alone.
        index = Path(folder) / "index"
        shutil.copyfile(Path(_git(top, "rev-parse", "--path-format=absolute", "--git-path", "index").strip()), index)
        if new_files:
            _git(top, "add", "--intent-to-add", "--", *new_files, GIT_INDEX_FILE=str(index))
        return _git(top, "diff", "--binary", "--no-ext-diff", "HEAD", GIT_INDEX_FILE=str(index))


def _git(folder: Path, *arguments: str, **environment: str) -> str:
    # Without optional locks, git status cannot block a git command of the user.
    outcome = subprocess.run(
        ["git", "-C", str(folder), *arguments],
        check=True,
        capture_output=True,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "GIT_OPTIONAL_LOCKS": "0", "LC_ALL": "C", **environment},
    )
    return os.fsdecode(outcome.stdout)


@cache
def _machine() -> dict[str, Any]:
    return {
        "host": socket.gethostname(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "processor": processor_name(),
        "cores": os.cpu_count(),
        "cores_allowed": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
    }


def processor_name() -> str:
    """The model of this machine's processor, as the system names it."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text(errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _threads() -> dict[str, Any]:
    threads: dict[str, Any] = {name: os.environ[name] for name in _THREAD_VARIABLES if name in os.environ}
    if "numpy" in sys.modules:
        from threadpoolctl import threadpool_info  # type: ignore[import-untyped]

        threads["pools"] = [
            {key: pool.get(key) for key in ("user_api", "internal_api", "version", "num_threads", "architecture")}
            for pool in threadpool_info()
        ]
    return threads


def _torch() -> dict[str, Any] | None:
    torch = sys.modules.get("torch")
    if torch is None:
        return None
    return {
        "version": str(torch.__version__),
        "build": torch.version.git_version,
        "cpu_capability": torch.backends.cpu.get_cpu_capability(),
        "threads": torch.get_num_threads(),
        "deterministic": torch.are_deterministic_algorithms_enabled(),
        "default_dtype": str(torch.get_default_dtype()),
    }


def _processor_seconds() -> float:
    own, children = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime
