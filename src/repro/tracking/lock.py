"""One process makes a stage; the others wait and then share its result.

The lock is the operating system's own (flock), so it ends with its process, however that ends: a dead process never
blocks another. On a shared file system (NFS, Lustre, BeeGFS) it holds across machines where these support flock, their
usual set-up; elsewhere filelock falls back to marker files, and breaks those whose process on the same host is gone.
The holder's host and process number lie in the working folder, for the messages of those that wait.
"""

import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from repro.tracking import progress

_POLL_S = 0.1


@contextmanager
def held(lock: Path, holder: Path, what: str) -> Iterator[None]:
    """Hold a lock, waiting as long as needed; one notice names the holder (read from the `holder` file)."""
    lock.parent.mkdir(parents=True, exist_ok=True)
    handle = FileLock(lock, poll_interval=_POLL_S)
    try:
        handle.acquire(timeout=0)
    except Timeout:
        progress.notice(f"shares {what} with {holder_text(holder)}, which is making it: waiting for it")
        handle.acquire()
    try:
        yield
    finally:
        handle.release()


def is_held(lock: Path) -> bool:
    """Whether a living process holds the lock."""
    if not lock.exists():
        return False
    try:
        with FileLock(lock, timeout=0):
            return False
    except Timeout:
        return True
    except OSError:
        return False  # on a read-only store nothing is being made


def holder() -> dict[str, object]:
    """Host and process number, for other processes to read while this one holds a lock."""
    return {"host": socket.gethostname(), "pid": os.getpid()}


def holder_text(file: Path) -> str:
    """The holder as "process 123 on host"."""
    try:
        content = json.loads(file.read_bytes())
        return f"process {content['pid']} on {content['host']}"
    except (OSError, ValueError, KeyError):
        return "another process"
