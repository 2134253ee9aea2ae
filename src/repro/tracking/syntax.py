"""One source file as its syntax tree: its statements and imports, whatever its comments and layout."""

from __future__ import annotations

import ast
import hashlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.errors import UserError


@dataclass(frozen=True)
class Source:
    """Digest of a file's syntax tree, the modules of its own package that it imports, and the libraries."""

    digest: str
    imports: tuple[str, ...]
    libraries: tuple[str, ...]


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
    for other in c_files(path):
        digest.update(other.read_bytes())
    return Source(
        digest=digest.hexdigest()[:16],
        imports=tuple(name for name in imports if within(name, root)),
        libraries=tuple(sorted(tops - {root} - sys.stdlib_module_names)),
    )


def c_files(path: Path) -> list[Path]:
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
