"""The process that is timed: one thread for its numerical libraries, and its peak memory."""

import ctypes
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import torch
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

_STATUS, _RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit torch, BLAS and OpenMP to one thread each, then restore their numbers of threads."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with threadpool_limits(limits=1):
            yield
    finally:
        torch.set_num_threads(before)


def peak_mib(call: Callable[[], object]) -> float:
    """MiB of resident memory that one call added at its peak; nan where the system does not report it."""
    try:
        # returns freed memory to the system, so that the call cannot reuse it unnoticed
        ctypes.CDLL("libc.so.6").malloc_trim(0)
        _RESET.write_text("5")  # resets the peak
        before = _read("VmRSS")
        call()
        return max(_read("VmHWM") - before, 0.0)
    except (OSError, AttributeError, StopIteration):
        return math.nan


def _read(key: str) -> float:
    lines = (line for line in _STATUS.read_text().splitlines() if line.startswith(key))
    return int(next(lines).split()[1]) / 1024
