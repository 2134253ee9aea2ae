"""Where plugins lie outside of this package: folders that a user names, and installed packages.

Such a folder repeats the layout of this project: models/kinds/NAME.py, mechanics/systems/NAME.py, ..., the settings in
conf/GROUP/NAME.yaml, and, where there are some, experiments/NAME.yaml and paper/.
"""

import os
from collections.abc import Iterable
from functools import cache
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from repro.errors import UserError

SOURCE = Path(__file__).resolve().parents[1]
# The folder with conf/, experiments/ and paper/: the checkout; within the package where it was installed from a wheel.
PROJECT = SOURCE.parents[1] if (SOURCE.parents[1] / "conf" / "config.yaml").is_file() else SOURCE / "project"
VARIABLE = "REPRO_PLUGINS"  # folders, separated as in PATH; processes that are started inherit it
ENTRY_POINTS = "repro.plugins"  # group in a package's metadata; each entry names a package whose folder holds plugins


@cache
def plugin_roots() -> tuple[Path, ...]:
    """The folders with plugins of the user, those of $REPRO_PLUGINS first; UserError for one that does not exist."""
    named = [Path(word).expanduser().absolute() for word in os.environ.get(VARIABLE, "").split(os.pathsep) if word]
    for folder in named:
        if not folder.is_dir():
            raise UserError(f"{VARIABLE}={folder}: there is no such folder")
    return tuple(dict.fromkeys([*named, *_installed()]))


def add_root(folder: str) -> None:
    """Add a folder with plugins, for this process and those that it starts; UserError where there is none."""
    path = Path(folder).expanduser().absolute()
    if not path.is_dir():
        raise UserError(f"--plugins {folder}: there is no such folder")
    os.environ[VARIABLE] = os.pathsep.join([str(path), *filter(None, [os.environ.get(VARIABLE)])])
    plugin_roots.cache_clear()


def search_path(package: str, path: Iterable[str]) -> list[str]:
    """The `__path__` of a package of plugins: its own folder, then the folder of the same place below every root."""
    place = Path(*package.split(".")[1:])
    return [*path, *(str(root / place) for root in plugin_roots() if (root / place).is_dir())]


def _installed() -> Iterable[Path]:
    for entry in entry_points(group=ENTRY_POINTS):
        if (spec := find_spec(entry.module)) is not None:
            yield from (Path(place) for place in spec.submodule_search_locations or ())
