"""Versions of third-party libraries, by the name they are imported under."""

from __future__ import annotations

from functools import cache
from importlib import metadata

ABSENT = "absent"
# Libraries that are installed under another name than the imported one; looking others up takes 0.1 s.
_INSTALLED_AS = {"sklearn": "scikit-learn", "yaml": "PyYAML", "rerun": "rerun-sdk", "hydra": "hydra-core"}


@cache
def _distributions() -> dict[str, list[str]]:
    return dict(metadata.packages_distributions())


@cache
def version(module: str) -> str:
    """Public version of the library that provides a top-level module, or "absent".

    The local part (2.13.0+cpu) is dropped: it names a build, and provenance keeps it.
    """
    try:
        full = metadata.version(_INSTALLED_AS.get(module, module))
    except metadata.PackageNotFoundError:
        names = _distributions().get(module)
        if not names:
            return ABSENT
        full = metadata.version(sorted(names)[0])
    return full.partition("+")[0]
