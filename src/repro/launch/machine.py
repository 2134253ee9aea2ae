"""What the jobs of this machine may take together: cores and memory."""

import ctypes
import math
import re
from contextlib import suppress
from pathlib import Path

SHARE = 0.78  # of what is free; the rest: launcher, file cache, and a peak beyond what is expected
M_TRIM_THRESHOLD, M_MMAP_MAX = -1, -4  # of mallopt, GNU's <malloc.h>
LIMITS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")  # of a container, v2 and v1


def allowed_cores() -> int:
    """Cores after affinity and the limits of a container or a batch system, at least 1."""
    import joblib  # takes longer to load than most commands need

    return int(joblib.cpu_count())


def memory_for_jobs_mib() -> float:
    """A share of what is available or of what a container allows, if that is less; infinite where neither is known."""
    found = [_number(limit) / 1024**2 for limit in LIMITS]
    available = re.search(r"MemAvailable:\s*(\d+) kB", _text("/proc/meminfo"))
    found.append(int(available[1]) / 1024 if available else math.inf)
    return SHARE * min(found)


def reuse_freed_memory() -> None:
    """Keep what this process frees for its next arrays, where the C library can.

    Of arrays of many MiB that come and go the system would clear every page anew: a quarter of the time of a fit that
    makes its Jacobian at every step.
    """
    with suppress(OSError, AttributeError):
        keep = ctypes.CDLL(None).mallopt
        keep(M_TRIM_THRESHOLD, 2**31 - 1)
        keep(M_MMAP_MAX, 0)


def _number(file: str) -> float:
    text = _text(file).strip()
    return float(text) if text.isdigit() else math.inf  # "max" is no limit


def _text(file: str) -> str:
    try:
        return Path(file).read_text()
    except OSError:
        return ""
