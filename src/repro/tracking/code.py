"""What a stage's code is: the syntax trees of every module it can reach, and the libraries these import.

Only static imports are followed, those inside functions too: a module that is loaded by a computed name must be listed
by the stage. Comments, docstrings, layout and names needed for type checking alone change nothing. Imports of `errors`
and of `tracking` are not followed: they decide what is said and where results lie, never what the results are.
"""

from __future__ import annotations

import ast
import hashlib
import json
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking import libraries
from repro.tracking.files import write_atomically
from repro.tracking.paths import Paths, outputs_root

_begun = time.time()
_loaded_before: dict[str, float] = {}
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

    A process looks at each file once: ids made later in the same process agree with the code it has loaded. Raises
    UserError for a module that does not exist, for a syntax error, and for a file edited after this process loaded it.
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


def begin_job() -> None:
    """Mark the fork of a job: what is loaded from here on is younger than what its parent had loaded."""
    global _begun  # noqa: PLW0603 - one job a process
    _loaded_before.update(dict.fromkeys(sys.modules, _begun))
    _begun = time.time()
    closure.cache_clear()


def _reached(importer: str, imports: Sequence[str]) -> Iterator[str]:
    """Modules that an import line runs: `a.b.c` runs a.b and, where it is a module, a.b.c."""
    root = importer.partition(".")[0]
    for name in imports:
        parts = name.split(".")
        for plumbing in (f"{root}.tracking", f"{root}.errors"):
            if _within(name, plumbing) and not _within(importer, plumbing):
                break
        else:
            # The root package is the front porch: it re-exports names and holds nothing that a stage uses.
            candidates = [".".join(parts[:length]) for length in range(2, len(parts) + 1)]
            yield from (candidate for candidate in candidates if _file(candidate) is not None)


def _within(module: str, package: str) -> bool:
    return module == package or module.startswith(package + ".")


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
        stat = path.stat()
        now = time.time()
        if module in sys.modules and _loaded_before.get(module, _begun) < stat.st_mtime <= now:
            raise UserError(f"{path} was edited while this command was running: start the same command again")
        stamp = [stat.st_mtime_ns, stat.st_size, module]
        entry = self.known.get(str(path))
        if entry is None or entry["stamp"] != stamp:
            entry = {"stamp": stamp, **_analyse(path, module)}
            if now - stat.st_mtime > _SETTLED_S:
                self.known[str(path)] = entry
                self.changed = True
        return entry

    def save(self) -> None:
        # A cache that cannot be written (read-only results) costs time, nothing else.
        if self.changed:
            with suppress(OSError):
                write_atomically(self.cache_file, json.dumps({"format": _FORMAT, "files": self.known}).encode())


def _analyse(path: Path, module: str) -> dict[str, Any]:
    try:
        tree = ast.parse(path.read_bytes(), filename=str(path))
    except SyntaxError as error:
        raise UserError(f"{path}, line {error.lineno}: {error.msg}") from error
    root = module.partition(".")[0]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    imports = sorted(set(_imports(tree, package)))
    tops = {name.partition(".")[0] for name in imports}
    return {
        "digest": hashlib.sha256(_text(tree).encode()).hexdigest()[:16],
        "imports": [name for name in imports if _within(name, root)],
        "libraries": sorted(tops - {root} - sys.stdlib_module_names),
    }


def _imports(node: ast.AST, package: str) -> Iterator[str]:
    """Dotted names of everything imported below a node; `from a import b` gives a.b."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            parents = package.split(".")
            base = ".".join([*parents[: len(parents) - node.level + 1], *([base] if base else [])])
        yield from (f"{base}.{alias.name}" for alias in node.names)
    elif isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING"):
        for statement in node.orelse:
            yield from _imports(statement, package)
    else:
        for child in ast.iter_child_nodes(node):
            yield from _imports(child, package)


def _text(node: Any) -> str:
    """A syntax tree as text that is equal under every Python version: no docstrings, no positions, no empty fields."""
    if isinstance(node, list):
        return "[" + ",".join(map(_text, node)) + "]"
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = []
    for name, value in ast.iter_fields(node):
        if name == "body" and isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            value = [statement for statement in value if not _is_docstring(statement)]  # noqa: PLW2901
        if value is not None and value != []:
            fields.append(f"{name}={_text(value)}")
    return f"{type(node).__name__}({','.join(fields)})"


def _is_docstring(node: ast.stmt) -> bool:
    """A bare text, wherever it stands: it does nothing when run."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
