"""`repro clean`: removes leftovers, never a current result."""

import itertools
import shutil
import time
from argparse import Namespace
from collections.abc import Iterator, Sequence
from contextlib import nullcontext, suppress
from pathlib import Path

from filelock import FileLock, Timeout
from rich.filesize import decimal

from repro.errors import UserError
from repro.tracking.paths import DAMAGED, FAILED, WORK, Paths, outputs_root
from repro.tracking.survey import StageState, survey

SHELVES = {"failed": FAILED, "damaged": DAMAGED, "interrupted": WORK}
USUAL = (*SHELVES, "logs")
SORTS = (*USUAL, "stale")
_LOG_AGE_S = 7 * 24 * 3600


def main(arguments: Namespace) -> int:
    """List the leftovers; remove them with --yes."""
    if unknown := [sort for sort in arguments.sorts if sort not in SORTS]:
        raise UserError(f"repro clean: there is no {unknown[0]} to remove; choose from {', '.join(SORTS)}")
    paths = Paths(outputs_root())
    folders = removable(paths, arguments.sorts or USUAL)
    sizes = {folder: sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) for folder in folders}
    shown = list(remove(paths, folders)) if arguments.yes else folders
    for folder in shown:
        print(f"{decimal(sizes[folder]):>10}  {folder.relative_to(paths.root)}")
    total, left = decimal(sum(sizes[folder] for folder in shown)), "can be removed: add --yes."
    print(f"{total} {'removed.' if arguments.yes else left}" if shown or arguments.yes else "Nothing to remove.")
    return 0


def removable(paths: Paths, sorts: Sequence[str]) -> list[Path]:
    """The folders of the chosen sorts: failed attempts, damaged stages kept aside, working folders of ended processes
    (their checkpoints too), logs older than a week, stages that the present code no longer gives."""
    folders: list[Path] = []
    shelves = [shelf for sort, shelf in SHELVES.items() if sort in sorts]
    for kind, shelf in itertools.product(paths.kinds(), shelves):
        folders += [paths.folder(kind, id, shelf) for id in paths.ids(kind, shelf)]
    if "logs" in sorts and paths.logs.is_dir():
        before = time.time() - _LOG_AGE_S
        folders += [folder for folder in sorted(paths.logs.iterdir()) if folder.stat().st_mtime < before]
    if "stale" in sorts:
        folders += [paths.folder(item.kind, item.id) for item in survey(paths) if item.state is StageState.STALE]
    return folders


def remove(paths: Paths, folders: Sequence[Path]) -> Iterator[Path]:
    """Remove folders and yield each; a stage that a living process is making is left alone."""
    for folder in folders:
        being_made = folder.parent.name == WORK
        lock = FileLock(paths.lock(folder.parent.parent.name, folder.name), timeout=0) if being_made else nullcontext()
        with suppress(Timeout), lock:
            shutil.rmtree(folder)
            yield folder
