"""Source files as this process loaded them: digests of their syntax trees, and what they import.

Comments, docstrings and layout change no digest. Python runs what a file held when it was loaded, so a digest that is
read later describes the running code only if the file did not change in between. A job is forked from a server that has
loaded modules before it; what the server has recorded of them stays true for the job, whatever is edited meanwhile.
"""

from __future__ import annotations

import ast
import hashlib
import json
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking.files import write_text
from repro.tracking.paths import source_cache

# A file younger than this may change again within one tick of the clock of its file system.
_SETTLED_S = 2.0
_FORMAT = 2


@dataclass(frozen=True)
class Source:
    """Digest of a file's syntax tree, the modules of its own package that it imports, and the libraries."""

    digest: str
    imports: tuple[str, ...]
    libraries: tuple[str, ...]


class SourceReader:
    """Reads source files of one process.

    started    since when modules have been loaded by this process itself
    inherited  module -> the latest start of the process that had loaded it before the fork
    recorded   module -> source of a module that is loaded, whatever its file holds by now
    unloaded   module -> file and source of a module when it was read, before it was loaded
    """

    def __init__(self, cache_file: Path) -> None:
        self.cache_file = cache_file
        self.started = time.time()
        self.inherited: dict[str, float] = {}
        self.recorded: dict[str, Source] = {}
        self.unloaded: dict[str, tuple[Path, Source]] = {}
        self._cached: dict[str, Any] | None = None
        self._changed = False

    def read(self, path: Path, module: str) -> Source:
        """Digest, imports and libraries of a module's file.

        Raises UserError for a syntax error, and for a file that was edited after this process loaded it.
        """
        if module in self.recorded:
            return self.recorded[module]
        changed = _stamp(path)[0] / 1e9
        if module in sys.modules and self.inherited.get(module, self.started) < changed <= time.time():
            raise _edited(path)
        source = self._analysed(path, module)
        if module not in sys.modules:
            self.unloaded.setdefault(module, (path, source))
        return source

    def _analysed(self, path: Path, module: str) -> Source:
        """What a file holds now, from the cache where its time of change and its size are as there."""
        key, stamp = f"{path} {module}", _stamp(path)
        entry = self._cache().get(key)
        if entry is not None and tuple(entry["stamp"]) == stamp:
            return Source(entry["digest"], tuple(entry["imports"]), tuple(entry["libraries"]))
        source = analyse(path, module)
        if time.time() - stamp[0] / 1e9 > _SETTLED_S:
            self._cache()[key] = {"stamp": stamp, **asdict(source)}
            self._changed = True
        return source

    def save(self) -> None:
        """Write what is new to the cache; files that no longer exist are dropped."""
        if not self._changed:
            return
        self._changed = False
        files = {key: entry for key, entry in self._cache().items() if Path(key.rpartition(" ")[0]).exists()}
        # A cache that cannot be written costs time, nothing else.
        with suppress(OSError):
            write_text(self.cache_file, json.dumps({"format": _FORMAT, "files": files}))

    def check_unchanged(self, modules: Iterable[str]) -> None:
        """Raise UserError for a module that was edited after it was read and before this process loaded it."""
        for module in modules:
            if module in sys.modules and module in self.unloaded:
                path, source = self.unloaded[module]
                if not path.exists() or self._analysed(path, module) != source:
                    raise _edited(path)

    def record(self, files: Iterable[tuple[str, Path]]) -> None:
        """Record the loaded modules whose files have not changed since this process started, for jobs forked later."""
        for module, path in files:
            if _stamp(path)[0] / 1e9 <= self.started:
                self.recorded[module] = self.read(path, module)
        self.save()

    def begin_job(self) -> None:
        """Mark the fork of a job: what is loaded from here on is younger than what its parent had loaded."""
        self.inherited.update(dict.fromkeys(sys.modules, self.started))
        self.started = time.time()
        self.unloaded.clear()

    def _cache(self) -> dict[str, Any]:
        if self._cached is None:
            try:
                stored = json.loads(self.cache_file.read_bytes())
                self._cached = dict(stored["files"]) if stored["format"] == _FORMAT else {}
            except (OSError, ValueError, KeyError, TypeError):
                self._cached = {}
        return self._cached


def analyse(path: Path, module: str) -> Source:
    """Read a source file; the C files of a folder belong to its `__init__`.

    Raises UserError with file and line for a syntax error.
    """
    try:
        tree = ast.parse(path.read_bytes(), filename=str(path))
    except SyntaxError as error:
        raise UserError(f"{path}, line {error.lineno}: {error.msg}") from error
    root = module.partition(".")[0]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    imports = sorted(set(_imports(tree, package)))
    tops = {name.partition(".")[0] for name in imports}
    digest = hashlib.sha256(_text(tree).encode())
    for other in _c_files(path):
        digest.update(other.read_bytes())
    return Source(
        digest=digest.hexdigest()[:16],
        imports=tuple(name for name in imports if within(name, root)),
        libraries=tuple(sorted(tops - {root} - sys.stdlib_module_names)),
    )


def _c_files(path: Path) -> list[Path]:
    """The C files that belong to a module: those in the folder of an `__init__`."""
    return sorted(path.parent.glob("*.c")) if path.name == "__init__.py" else []


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
    """A bare text in any place: it has no effect when run."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def within(module: str, package: str) -> bool:
    """Whether a dotted name is a package or inside it."""
    return module == package or module.startswith(package + ".")


def _stamp(path: Path) -> tuple[int, int]:
    """Time of change in ns, and size, C files included."""
    files = [each.stat() for each in (path, *_c_files(path))]
    return max(file.st_mtime_ns for file in files), sum(file.st_size for file in files)


def _edited(path: Path) -> UserError:
    return UserError(f"{path} was edited while this command was running: start the same command again")


READER = SourceReader(source_cache())
