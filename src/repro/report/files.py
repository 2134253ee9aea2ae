"""Where the report's files lie, and how they are written: complete or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from repro.errors import UserError


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary sibling to write to; it takes the place of `path` only when the block succeeds."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # The suffix stays: writers choose their format by it.
        temporary = path.with_name(f".{path.stem}-{os.getpid()}{path.suffix}")
        try:
            yield temporary
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        message = f"cannot write {path}: {error.strerror or error}; free the disk or choose another folder"
        raise UserError(message) from error


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically, UTF-8."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def project_folder() -> Path:
    """Return the checkout that holds paper/ and README.md. Raises UserError where the package lies outside of one."""
    folder = Path(__file__).resolve().parents[3]
    if not (folder / "paper" / "claims.yaml").is_file():
        message = f"paper/claims.yaml is not in {folder}: the report needs the project's checkout (pip install -e .)"
        raise UserError(message)
    return folder
