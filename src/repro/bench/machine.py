"""What a timing depends on besides code and libraries."""

import os
import platform
import subprocess
from pathlib import Path

from repro.mechanics.c_library import compiler, has_compiler


def describe() -> dict[str, object]:
    """Processor, cores, operating system, Python and compiler of this machine, as plain data."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "compiler": _compiler(),
    }


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    lines = information.read_text(errors="replace").splitlines() if information.is_file() else []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def _compiler() -> str | None:
    if not has_compiler():
        return None
    told = subprocess.run([compiler(), "--version"], capture_output=True, text=True, check=False).stdout
    return told.partition("\n")[0]
