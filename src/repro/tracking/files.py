"""Writing files so that a kill at any moment leaves either the old content or the new one."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking.paths import ROOT_VARIABLE, TEMPORARY_SUFFIX

_MENDS = {
    errno.ENOSPC: "the disk is full; free some space",
    errno.EDQUOT: "the disk quota is used up; free some space",
    errno.EFBIG: "the largest allowed file size is reached; raise it (ulimit -f)",
    errno.EROFS: "the file system is read-only; mount it for writing",
    errno.EACCES: "permission is denied; mend the rights of the folder",
    errno.EPERM: "permission is denied; mend the rights of the folder",
}
_NO_ROOM_BYTES = 64 * 1024


def plain(value: Any) -> Any:
    """Numbers of numpy, tuples, sets and paths as plain JSON values; raises TypeError for anything else."""
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, set | frozenset):
        return sorted(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "items"):
        return dict(value)
    raise TypeError(f"{type(value).__name__} {value!r} is not plain data (numbers, text, lists, dictionaries)")


def canonical(value: Any) -> bytes:
    """The one JSON text of a value: sorted keys, no blanks."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), default=plain).encode()


def plain_copy(value: Any) -> Any:
    """The value as it reads back from JSON."""
    return json.loads(json.dumps(value, default=plain))


def flattened(value: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested dictionaries as one, with dotted keys."""
    flat: dict[str, Any] = {}
    for key, item in value.items():
        if isinstance(item, Mapping) and item:
            flat.update(flattened(item, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = item
    return flat


def digest(value: Any) -> str:
    """SHA-256 of the canonical JSON text, in hexadecimal."""
    return hashlib.sha256(canonical(value)).hexdigest()


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes, in hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def sync(path: Path) -> None:
    """Force a file or a folder's list of names to the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_atomically(path: Path, content: bytes) -> None:
    """Write aside, force to disk, rename: the file is old or new, never half."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f"{path.name}.{os.getpid()}{TEMPORARY_SUFFIX}")
    try:
        with temporary.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    sync(path.parent)


def write_json(path: Path, value: Any) -> None:
    """`write_atomically` of readable JSON."""
    write_atomically(path, (json.dumps(value, indent=1, default=plain) + "\n").encode())


def disk_trouble(error: Exception, folder: Path) -> UserError | None:
    """The UserError that explains a full disk, a read-only mount or missing rights in a folder; None for other errors.

    A library may hide the cause of a failed write, so on a full disk every error counts as one.
    """
    number = error.errno if isinstance(error, OSError) else None
    if number in (errno.EACCES, errno.EPERM, errno.EROFS):
        filename = getattr(error, "filename", None)
        number = number if filename is None or Path(os.fsdecode(filename)).is_relative_to(folder) else None
    elif number not in _MENDS:
        number = errno.ENOSPC if _is_full(folder) else None
    if number is None:
        return None
    return UserError(
        f"cannot write in {folder}: {_MENDS[number]}, or choose another folder with {ROOT_VARIABLE}=/some/folder. "
        "Finished work is kept; the same command goes on from there."
    )


@contextmanager
def disk_errors_explained(folder: Path) -> Iterator[None]:
    """Raise the `disk_trouble` of an OSError in its place."""
    try:
        yield
    except OSError as error:
        trouble = disk_trouble(error, folder)
        if trouble is None:
            raise
        raise trouble from error


def check_writable(folder: Path) -> None:
    """UserError when a folder takes no new file: a full disk, a read-only mount, missing rights."""
    with disk_errors_explained(folder):
        write_atomically(folder / ".cache" / "probe", b"0" * _NO_ROOM_BYTES)
        (folder / ".cache" / "probe").unlink(missing_ok=True)


def _is_full(folder: Path) -> bool:
    while not folder.exists():
        folder = folder.parent
    return shutil.disk_usage(folder).free < _NO_ROOM_BYTES


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
