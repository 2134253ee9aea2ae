"""What a stage's code is: the syntax trees of every module it can reach, and the libraries these import.

Only static imports are followed, those inside functions too: a module that is loaded by a computed name must be listed
by the stage. Comments, docstrings, layout and names needed for type checking alone change nothing. Imports of `errors`
and of `tracking` are not followed: they decide messages and where results lie, never what the results are.

Python runs what a file held when it was loaded, so a digest that is read later describes the running code only if the
file did not change in between. A job is forked from a server that has loaded modules before it; what the server has
recorded of them stays true for the job, whatever is edited meanwhile.
"""

import ast
import hashlib
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.plugins.roots import plugin_roots
from repro.tracking.cache import Cache
from repro.tracking.paths import source_cache
from repro.tracking.record import Identity

# Libraries that are installed under another name than the imported one; looking others up takes 0.1 s.
_INSTALLED_AS = {"sklearn": "scikit-learn", "yaml": "PyYAML", "rerun": "rerun-sdk", "hydra": "hydra-core"}
# A file younger than this may change again within one tick of the clock of its file system.
_SETTLED_S = 2.0
_FORMAT = 3  # of what is read off a file


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
        waiting += _reached(module, tuple(source.imports))
    READER.save()
    versions = {name: version(name) for name in sorted(names)}
    return Identity(code=dict(sorted(modules.items())), libraries=versions, modules=tuple(sorted(entries)))


def remember_loaded() -> None:
    """Record this package's loaded modules for jobs forked from here: later edits do not reach their code.

    A module whose file has changed since this process started is left out.
    """
    package = __name__.partition(".")[0]
    for module in sorted(name for name in sys.modules if _within(name, package)):
        path = _file(module)
        if path is not None and _stamp(path)[0] / 1e9 <= READER.started:
            source = READER.recorded[module] = READER.read(path, module)
            # Looked up here, for all jobs.
            _reached(module, tuple(source.imports))
            list(map(version, source.libraries))
    READER.save()


def begin_job() -> None:
    """Mark the fork of a job: what is loaded from here on is younger than what its parent had loaded."""
    READER.inherited.update(dict.fromkeys(sys.modules, READER.started))
    READER.started = time.time()
    READER.unloaded.clear()
    READER.forked = True
    closure.cache_clear()


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


@dataclass(frozen=True)
class Source:
    """Digest of a file's syntax tree, the modules of its own package that it imports, and the libraries."""

    digest: str
    imports: Sequence[str]
    libraries: Sequence[str]


class SourceReader:
    """Reads source files of one process.

    started    since when modules have been loaded by this process itself
    inherited  module -> the latest start of the process that had loaded it before the fork
    recorded   module -> source of a module that is loaded, whatever its file holds by now
    unloaded   module -> file and source of a module when it was read, before it was loaded
    forked     the cache was read before the fork of this process, and others may have added to it since
    cache      what files held, by path and module
    """

    def __init__(self, cache: Cache) -> None:
        self.cache = cache
        self.started = time.time()
        self.inherited: dict[str, float] = {}
        self.recorded: dict[str, Source] = {}
        self.unloaded: dict[str, tuple[Path, Source]] = {}
        self.forked = False

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
        if self.forked and key not in self.cache.values:
            self.cache, self.forked = Cache(self.cache.file, _FORMAT), False
        stored = self.cache.values.get(key)
        if stored is not None and stored["stamp"] == stamp:
            return Source(**stored["source"])
        source = analyse(path, module)
        if time.time() - stamp[0] / 1e9 > _SETTLED_S:
            self.cache.values[key] = {"stamp": stamp, "source": asdict(source)}
        return source

    def save(self) -> None:
        """Write what is new to the cache; files that no longer exist are dropped."""
        if self.cache.changed:
            self.cache.retain({key for key in self.cache.values if Path(key.rpartition(" ")[0]).exists()})
            self.cache.save()

    def check_unchanged(self, modules: Iterable[str]) -> None:
        """Raise UserError for a module that was edited after it was read and before this process loaded it."""
        for module in modules:
            if module in sys.modules and module in self.unloaded:
                path, source = self.unloaded[module]
                if not path.exists() or self._analysed(path, module) != source:
                    raise _edited(path)


READER = SourceReader(Cache(source_cache(), _FORMAT))


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
    # Lists, as they read back from the cache.
    own, libraries = [name for name in imports if _within(name, root)], sorted(tops - {root} - sys.stdlib_module_names)
    return Source(digest.hexdigest()[:16], own, libraries)


@cache
def _reached(importer: str, imports: tuple[str, ...]) -> tuple[str, ...]:
    """Modules that import lines run: `a.b.c` runs a.b and, where it is a module, a.b.c."""
    root = importer.partition(".")[0]
    outside = [room for room in (f"{root}.tracking", f"{root}.errors") if not _within(importer, room)]
    inside = [name.split(".") for name in imports if not any(_within(name, room) for room in outside)]
    # The root package only re-exports names that no stage uses.
    candidates = (".".join(parts[:length]) for parts in inside for length in range(2, len(parts) + 1))
    return tuple(name for name in dict.fromkeys(candidates) if _file(name) is not None)


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


def _within(module: str, package: str) -> bool:
    """Whether a dotted name is a package or inside it."""
    return module == package or module.startswith(package + ".")


def _stamp(path: Path) -> list[int]:
    """Time of change in ns, and size, C files included; a list, as it reads back from the cache."""
    files = [each.stat() for each in (path, *_c_files(path))]
    return [max(file.st_mtime_ns for file in files), sum(file.st_size for file in files)]


def _c_files(path: Path) -> list[Path]:
    """The C files that belong to a module: those in the folder of an `__init__`."""
    return sorted(path.parent.glob("*.c")) if path.name == "__init__.py" else []


def _edited(path: Path) -> UserError:
    return UserError(f"{path} was edited while this command was running: start the same command again")
