"""What a stage's code is: the syntax trees of every module it can reach, and the libraries these import.

Only static imports are followed, those inside functions too: a module that is loaded by a computed name must be listed
by the stage. Comments, docstrings, layout and names needed for type checking alone change nothing. Imports of `errors`
and of `tracking` are not followed: they decide what is said and where results lie, never what the results are.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking import libraries, syntax
from repro.tracking.files import write_text
from repro.tracking.paths import Paths, outputs_root

_begun = time.time()
_loaded_before: dict[str, float] = {}
_remembered: dict[str, dict[str, Any]] = {}
_looked_at_unloaded: dict[str, tuple[Path, dict[str, Any]]] = {}
# A file younger than this may change again within one tick of the clock of its file system.
_SETTLED_S = 2.0
_FORMAT = 1


@dataclass(frozen=True)
class Code:
    """The digests of the modules a stage reaches and the versions of the libraries these import."""

    modules: dict[str, str]
    libraries: dict[str, str]


@cache
def closure(entries: tuple[str, ...]) -> Code:
    """Code reached from the entry modules (full dotted names).

    Raises UserError for a module that does not exist, for a syntax error, and for a file edited after this process
    loaded it.
    """
    reader = _Reader(Paths(outputs_root()).code)
    modules: dict[str, str] = {}
    names: set[str] = set()
    waiting = list(entries)
    while waiting:
        module = waiting.pop()
        if module in modules:
            continue
        path = _file(module)
        if path is None:
            raise UserError(f"no module {module}: a stage names it as its code; look for a spelling mistake")
        source = reader.read(path, module)
        modules[module] = source["digest"]
        names.update(source["libraries"])
        waiting += [name for name in _reached(module, source["imports"]) if name not in modules]
    reader.save()
    return Code(dict(sorted(modules.items())), {name: libraries.version(name) for name in sorted(names)})


def check_unchanged(modules: Iterable[str]) -> None:
    """Raise UserError for a module that was edited between `closure` and the moment this process loaded it."""
    for module in modules:
        if module in sys.modules and module in _looked_at_unloaded:
            path, entry = _looked_at_unloaded[module]
            if not path.exists():
                raise _edited(path)
            if _stamp(path, module) != entry["stamp"] and syntax.analyse(path, module)["digest"] != entry["digest"]:
                raise _edited(path)


def remember_loaded() -> None:
    """Keep what this package's loaded modules are, for jobs forked from here: later edits do not reach their code."""
    reader = _Reader(Paths(outputs_root()).code)
    package = __name__.partition(".")[0]
    for module in sorted(name for name in sys.modules if syntax.within(name, package)):
        path = _file(module)
        if path is not None and path.stat().st_mtime <= _begun:
            _remembered[module] = reader.read(path, module)
    reader.save()


def begin_job() -> None:
    """Mark the fork of a job: what is loaded from here on is younger than what its parent had loaded."""
    global _begun  # noqa: PLW0603 - one job a process
    _loaded_before.update(dict.fromkeys(sys.modules, _begun))
    _begun = time.time()
    _looked_at_unloaded.clear()
    closure.cache_clear()


def _reached(importer: str, imports: Sequence[str]) -> Iterator[str]:
    """Modules that an import line runs: `a.b.c` runs a.b and, where it is a module, a.b.c."""
    root = importer.partition(".")[0]
    for name in imports:
        parts = name.split(".")
        for plumbing in (f"{root}.tracking", f"{root}.errors"):
            if syntax.within(name, plumbing) and not syntax.within(importer, plumbing):
                break
        else:
            # The root package is the front porch: it re-exports names and holds nothing that a stage uses.
            candidates = [".".join(parts[:length]) for length in range(2, len(parts) + 1)]
            yield from (candidate for candidate in candidates if _file(candidate) is not None)


@cache
def _root(name: str) -> Path | None:
    """Folder of a top-level package or file of a top-level module."""
    spec = find_spec(name)
    if spec is None or spec.origin is None or not spec.has_location:
        return None
    origin = Path(spec.origin)
    return origin.parent if spec.submodule_search_locations else origin


@cache
def _file(module: str) -> Path | None:
    name, *rest = module.split(".")
    root = _root(name)
    if root is None or not root.is_dir():
        return None if rest else root
    place = root.joinpath(*rest)
    if rest and place.with_suffix(".py").is_file():
        return place.with_suffix(".py")
    return place / "__init__.py" if (place / "__init__.py").is_file() else None


class _Reader:
    """Reads source files through a cache on disk, keyed by path, time of change and size."""

    def __init__(self, cache_file: Path) -> None:
        self.cache_file = cache_file
        self.changed = False
        try:
            stored = json.loads(cache_file.read_bytes())
            self.known: dict[str, Any] = stored["files"] if stored["format"] == _FORMAT else {}
        except (OSError, ValueError, KeyError, TypeError):
            self.known = {}

    def read(self, path: Path, module: str) -> dict[str, Any]:
        """Digest, imports and libraries of one file."""
        if module in _remembered:
            return _remembered[module]
        changed, now = path.stat().st_mtime, time.time()
        if module in sys.modules and _loaded_before.get(module, _begun) < changed <= now:
            raise _edited(path)
        stamp = _stamp(path, module)
        entry = self.known.get(str(path))
        if entry is None or entry["stamp"] != stamp:
            entry = {"stamp": stamp, **syntax.analyse(path, module)}
            if now - changed > _SETTLED_S:
                self.known[str(path)] = entry
                self.changed = True
        if module not in sys.modules:
            _looked_at_unloaded.setdefault(module, (path, entry))
        return entry

    def save(self) -> None:
        # A cache that cannot be written (read-only results) costs time, nothing else.
        if self.changed:
            with suppress(OSError):
                write_text(self.cache_file, json.dumps({"format": _FORMAT, "files": self.known}))


def _stamp(path: Path, module: str) -> list[Any]:
    stat = path.stat()
    return [stat.st_mtime_ns, stat.st_size, module]


def _edited(path: Path) -> UserError:
    return UserError(f"{path} was edited while this command was running: start the same command again")
