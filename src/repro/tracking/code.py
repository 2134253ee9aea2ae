"""What a stage's code is: the syntax trees of every module it can reach, and the libraries these import.

Only static imports are followed, those inside functions too: a module that is loaded by a computed name must be listed
by the stage. Comments, docstrings, layout and names needed for type checking alone change nothing. Imports of `errors`
and of `tracking` are not followed: they decide messages and where results lie, never what the results are.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from repro.errors import UserError
from repro.plugins.roots import plugin_roots
from repro.tracking.record import Identity
from repro.tracking.source_reader import READER, within

# Libraries that are installed under another name than the imported one; looking others up takes 0.1 s.
_INSTALLED_AS = {"sklearn": "scikit-learn", "yaml": "PyYAML", "rerun": "rerun-sdk", "hydra": "hydra-core"}


@cache
def closure(entries: tuple[str, ...]) -> Identity:
    """The part of an identity that is code: what is reached from the entry modules (full dotted names).

    Raises UserError for a module that does not exist, for a syntax error, and for a file edited after this process
    loaded it.
    """
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
        source = READER.read(path, module)
        modules[module] = source.digest
        names.update(source.libraries)
        waiting += [name for name in _reached(module, source.imports) if name not in modules]
    READER.save()
    versions = {name: version(name) for name in sorted(names)}
    return Identity(code=dict(sorted(modules.items())), libraries=versions, modules=tuple(sorted(entries)))


def remember_loaded() -> None:
    """Record this package's loaded modules for jobs forked from here: later edits do not reach their code."""
    package = __name__.partition(".")[0]
    loaded = sorted(name for name in sys.modules if within(name, package))
    READER.record((module, path) for module in loaded if (path := _file(module)) is not None)


def begin_job() -> None:
    """Mark the fork of a job: what is loaded from here on is younger than what its parent had loaded."""
    READER.begin_job()
    closure.cache_clear()


def _reached(importer: str, imports: Sequence[str]) -> Iterator[str]:
    """Modules that an import line runs: `a.b.c` runs a.b and, where it is a module, a.b.c."""
    root = importer.partition(".")[0]
    for name in imports:
        parts = name.split(".")
        for room in (f"{root}.tracking", f"{root}.errors"):
            if within(name, room) and not within(importer, room):
                break
        else:
            # The root package only re-exports names that no stage uses.
            candidates = [".".join(parts[:length]) for length in range(2, len(parts) + 1)]
            yield from (candidate for candidate in candidates if _file(candidate) is not None)


@cache
def version(module: str) -> str:
    """Public version of the library that provides a top-level module, or "absent".

    The local part (2.13.0+cpu) is dropped: it names a build, and provenance keeps it.
    """
    try:
        full = metadata.version(_INSTALLED_AS.get(module, module))
    except metadata.PackageNotFoundError:
        names = metadata.packages_distributions().get(module)
        if not names:
            return "absent"
        full = metadata.version(sorted(names)[0])
    return full.partition("+")[0]


@cache
def _file(module: str) -> Path | None:
    name, *rest = module.split(".")
    spec = find_spec(name)
    if spec is None or spec.origin is None or not spec.has_location:
        return None
    root = Path(spec.origin).parent
    if not spec.submodule_search_locations:
        return None if rest else Path(spec.origin)
    for folder in (root, *plugin_roots()) if name == __name__.partition(".")[0] and rest else (root,):
        place = folder.joinpath(*rest)
        if rest and place.with_suffix(".py").is_file():
            return place.with_suffix(".py")
        if (place / "__init__.py").is_file():
            return place / "__init__.py"
    return None
