"""What the jobs of this machine may take together: cores and memory."""

import math
import re
from pathlib import Path

SHARE = 0.78  # of what is free; the rest: launcher, file cache, and a peak beyond what is expected
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


def _number(file: str) -> float:
    text = _text(file).strip()
    return float(text) if text.isdigit() else math.inf  # "max" is no limit


def _text(file: str) -> str:
    try:
        return Path(file).read_text()
    except OSError:
        return ""
