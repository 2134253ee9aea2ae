"""What a timing depends on besides code and libraries."""

import os
import platform
import subprocess

from repro.codegen.c_library import compiler, has_compiler
from repro.tracking.provenance import processor_name


def describe() -> dict[str, object]:
    """Processor, cores, operating system, Python and compiler of this machine, as plain data."""
    return {
        "processor": processor_name(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "compiler": _compiler(),
    }


def _compiler() -> str | None:
    if not has_compiler():
        return None
    version = subprocess.run([compiler(), "--version"], capture_output=True, text=True, check=False).stdout
    return version.partition("\n")[0]
