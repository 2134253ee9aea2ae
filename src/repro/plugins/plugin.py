"""Finds the modules that are chosen by name: a folder is the list of its choices."""

import difflib
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

from repro.errors import UserError
from repro.plugins.roots import SOURCE, plugin_roots


def plugin(folder: str, name: str) -> ModuleType:
    """The module of a choice, imported; UserError as for `plugin_module`."""
    return import_module(plugin_module(folder, name))


def plugin_module(folder: str, name: str) -> str:
    """Dotted name of the module of a choice, without importing it; UserError names the choices that exist.

    folder  dotted, below `repro`, e.g. "models.bases"
    """
    if name not in plugin_names(folder):
        raise UserError(not_allowed(folder, name, plugin_names(folder)))
    return f"{__name__.partition('.')[0]}.{folder}.{name}"


@cache
def plugin_names(folder: str) -> tuple[str, ...]:
    """Names of the choices in a folder, sorted, those of the user's plugins included; UserError for a name twice."""
    place = folder.replace(".", "/")
    files = [path for root in (SOURCE, *plugin_roots()) for path in (root / place).glob("[!_.]*.py")]
    places = {path.stem: path for path in reversed(files)}
    if hidden := [path for path in files if places[path.stem] != path]:
        raise UserError(f"{hidden[0]}: {places[hidden[0].stem]} has this name too; choose another")
    return tuple(sorted(places))


def not_allowed(key: str, value: Any, allowed: Iterable[str]) -> str:
    """The line for a value that is not one of the allowed words."""
    words = list(allowed)
    return f"{key} = {value!r}: allowed are {', '.join(words)}{nearest(str(value), words)}"


def nearest(word: str, allowed: Iterable[str]) -> str:
    """A hint at the allowed word that is spelt most alike, or nothing."""
    spelt = {name.lower(): name for name in allowed}
    close = difflib.get_close_matches(word.lower(), spelt, n=1)
    return f" (did you mean {spelt[close[0]]}?)" if close else ""
