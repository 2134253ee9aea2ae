"""Where a result comes from: source, machine, libraries, seeds, time and memory."""

from __future__ import annotations

import os
import platform
import resource
import socket
import sys
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from repro.tracking import git
from repro.tracking.files import file_digest
from repro.tracking.plain_data import flattened
from repro.tracking.record import Provenance
from repro.tracking.stage import Stage

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
    config = flattened(stage.config).items()
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


@cache
def _source(patches: Path) -> dict[str, Any]:
    state = git.state(patches)
    top = git.source_tree()
    pins = top / "constraints.txt" if top else None
    state["constraints_sha256"] = file_digest(pins) if pins and pins.is_file() else None
    return state


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
