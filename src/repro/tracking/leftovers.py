"""What may be removed from the store without losing a current result."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from repro.tracking.paths import Paths
from repro.tracking.survey import StageState, survey

# What can be removed, and the default choice.
SORTS = ("failed", "damaged", "interrupted", "logs", "stale")
USUAL = ("failed", "damaged", "interrupted", "logs")
_LOG_AGE_S = 7 * 24 * 3600


def removable(paths: Paths, sorts: Sequence[str]) -> list[Path]:
    """The folders of the chosen sorts: failed attempts, damaged stages kept aside, working folders of ended processes
    (their checkpoints too), logs older than a week, stages that the present code no longer gives."""
    folders: list[Path] = []
    for kind in paths.kinds():
        if "failed" in sorts:
            folders += [paths.failed(kind, id) for id in paths.ids(kind, ".failed")]
        if "damaged" in sorts:
            folders += sorted(paths.damaged(kind).glob("*"))
        if "interrupted" in sorts:
            folders += [paths.work(kind, id) for id in paths.ids(kind, ".work")]
    if "logs" in sorts and paths.logs.is_dir():
        folders += [folder for folder in sorted(paths.logs.iterdir()) if _age(folder) > _LOG_AGE_S]
    if "stale" in sorts:
        folders += [paths.folder(item.kind, item.id) for item in survey(paths) if item.state is StageState.STALE]
    return folders


def remove(paths: Paths, folders: Sequence[Path]) -> Iterator[Path]:
    """Remove folders and yield each; a stage that a living process is making is left alone."""
    for folder in folders:
        being_made = folder.parent.name == ".work"
        lock = FileLock(paths.lock(folder.parent.parent.name, folder.name), timeout=0) if being_made else nullcontext()
        with suppress(Timeout), lock:
            shutil.rmtree(folder)
            yield folder


def size_of(folder: Path) -> int:
    """Bytes of all files below a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _age(folder: Path) -> float:
    return time.time() - folder.stat().st_mtime
