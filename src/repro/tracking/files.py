"""Files: written so that a kill at any moment leaves either the old content or the new one; YAML, read quickly."""

import errno
import hashlib
import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking.paths import ROOT_VARIABLE, TEMPORARY_SUFFIX
from repro.tracking.plain_data import plain

_REMEDIES = {
    errno.ENOSPC: "the disk is full; free some space",
    errno.EDQUOT: "the disk quota is used up; free some space",
    errno.EFBIG: "the largest allowed file size is reached; raise it (ulimit -f)",
    errno.EROFS: "the file system is read-only; mount it for writing",
    errno.EACCES: "permission is denied; change the permissions of the folder",
    errno.EPERM: "permission is denied; change the permissions of the folder",
}
_NO_ROOM_BYTES = 64 * 1024


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


@contextmanager
def replacing(path: Path, *, keep_suffix: bool = False, forced: bool = True) -> Iterator[Path]:
    """Yield a temporary sibling to write to; when the block succeeds it is forced to disk and takes the name `path`.

    The file is old or new, never half, and nothing temporary stays unless the process is killed. `keep_suffix` is for
    libraries that choose the format by the suffix; a file of many that are made again together need not be `forced`.
    """
    suffix = f"{TEMPORARY_SUFFIX}{path.suffix if keep_suffix else ''}"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name(f"{path.name}.{os.getpid()}{suffix}")
        try:
            yield temporary
            if forced:
                sync(temporary)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
        if forced:
            sync(path.parent)
    except OSError as error:
        if error.errno is not None and error.filename is None:
            error.filename = str(path)  # a full disk names no file
        raise


def write_bytes(path: Path, content: bytes, *, forced: bool = True) -> None:
    """Write a file atomically."""
    with replacing(path, forced=forced) as temporary:
        temporary.write_bytes(content)


def write_text(path: Path, text: str, *, forced: bool = True) -> None:
    """Write a text file atomically, UTF-8."""
    write_bytes(path, text.encode(), forced=forced)


def write_json(path: Path, value: Any, *, forced: bool = True) -> None:
    """Write readable JSON atomically."""
    write_text(path, json.dumps(value, indent=1, default=plain) + "\n", forced=forced)


def read_yaml(path: Path) -> Any:
    """The content of a YAML file. Raises UserError where it cannot be read, or is no YAML."""
    import yaml

    try:  # the parser in C, where PyYAML has it, is ten times as fast
        return yaml.load(path.read_text(encoding="utf-8"), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (OSError, yaml.YAMLError) as error:
        raise UserError(f"{path} cannot be read: {' '.join(str(error).split())}") from error


def disk_trouble(error: Exception, folder: Path) -> UserError | None:
    """The UserError that explains a full disk, a read-only mount or missing permission in a folder, else None.

    A library may hide the cause of a failed write, so on a full disk every error counts as one.
    """
    number = error.errno if isinstance(error, OSError) else None
    if number in (errno.EACCES, errno.EPERM, errno.EROFS):
        filename = getattr(error, "filename", None)
        number = number if filename is None or Path(os.fsdecode(filename)).is_relative_to(folder) else None
    elif number not in _REMEDIES:
        usage = shutil.disk_usage(next(place for place in (folder, *folder.parents) if place.exists()))
        number = errno.ENOSPC if usage.total > 0 and usage.free < _NO_ROOM_BYTES else None
    if number is None:
        return None
    return UserError(
        f"cannot write in {folder}: {_REMEDIES[number]}, or choose another folder with {ROOT_VARIABLE}=/some/folder. "
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
    """Raise UserError when a folder takes no new file: a full disk, a read-only mount, missing permission."""
    with disk_errors_explained(folder):
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except FileNotFoundError:  # /proc and its like
            raise UserError(
                f"{folder} cannot be made; choose another folder with {ROOT_VARIABLE}=/some/folder"
            ) from None
        write_bytes(folder / ".cache" / "probe", b"0" * _NO_ROOM_BYTES)
        (folder / ".cache" / "probe").unlink(missing_ok=True)
