"""The store of finished stages: never a half one, never a stale one, never the same work twice."""

import itertools
import shutil
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking import lock, paths, progress, provenance, record
from repro.tracking.code import READER
from repro.tracking.files import disk_errors_explained, disk_trouble, file_digest, sync, write_json
from repro.tracking.paths import HOLDER_FILE, RUN_FILE, TEMPORARY_SUFFIX, Paths
from repro.tracking.plain_data import plain_copy
from repro.tracking.record import Damage, Failure, Record, StageOutcome, StoredFile
from repro.tracking.stage import Stage

NOTICES = "notices"  # the key of a summary that has the notices shown while the stage was made


class StageFailed(Exception):  # noqa: N818 - the outcome of a stage, known by this name everywhere
    """A stage ended in an exception; `record` holds it as data."""

    def __init__(self, record: Record) -> None:
        super().__init__(record)
        self.record = record

    def __str__(self) -> str:
        failure = self.record.failure or Failure("", "")
        return f"{self.record.id} failed: {failure.type}: {failure.message} (repro show {self.record.id})"


class Store:
    """All stages under one outputs root; safe to use from many processes and machines at once.

    A stage is made in a working folder that survives a kill: files whose names begin with "checkpoint" stay for the
    next attempt until the stage is finished; all others are removed before it.
    """

    def __init__(self, root: Path, overrides: Sequence[str] = ()) -> None:
        self.paths = Paths(Path(root).absolute())
        self.overrides = tuple(overrides)

    def find(self, id: str, *, kind: str = "", shelf: str = "", verify: bool = False) -> Record | None:
        """The finished stage of an id, or on the shelf FAILED its last failed attempt; None where there is none whole.

        Checks run.json and the sizes of the files; `verify` checks every byte.
        """
        for candidate in [kind] if kind else self.paths.kinds():
            with suppress(FileNotFoundError, Damage):
                return record.read(self.paths.folder(candidate, id, shelf), verify)
        return None

    def has(self, id: str, kind: str) -> bool:
        """Whether a finished stage lies in its folder, unread."""
        return (self.paths.folder(kind, id) / RUN_FILE).is_file()

    def records(self, kind: str) -> list[Record]:
        """All finished, undamaged stages of one kind, by id."""
        stages = (self.find(id, kind=kind) for id in self.paths.ids(kind))
        return [stage for stage in stages if stage is not None]

    def compute(self, stage: Stage, work: Callable[[Path], dict[str, Any]]) -> Record:
        """The stage's stored result, or a new one, made by `work(folder) -> summary`.

        Waits for another process that makes the same stage. Raises StageFailed when `work` raises (the failure is
        stored, and retried by the next call) and UserError when the disk is full or cannot be written.
        """
        stored = self.find(stage.id, kind=stage.kind)
        if stored is not None:
            return stored
        folder = self.paths.folder(stage.kind, stage.id, paths.WORK)
        with (
            disk_errors_explained(self.paths.root),
            lock.held(self.paths.lock(stage.kind, stage.id), folder / HOLDER_FILE, stage.id),
        ):
            self._move_aside_if_damaged(stage.kind, stage.id)
            stored = self.find(stage.id, kind=stage.kind)
            return stored if stored is not None else self._make(stage, work, folder)

    def verify(self, kind: str, id: str) -> Damage | None:
        """Check every byte of a finished stage; a damaged one is moved aside, so that its command makes it again."""
        with disk_errors_explained(self.paths.root):
            try:
                record.read(self.paths.folder(kind, id), verify=True)
            except FileNotFoundError:
                return None
            except Damage:
                with lock.held(self.paths.lock(kind, id), self.paths.folder(kind, id, paths.WORK) / HOLDER_FILE, id):
                    return self._move_aside_if_damaged(kind, id, verify=True)
        return None

    def _move_aside_if_damaged(self, kind: str, id: str, *, verify: bool = False) -> Damage | None:
        """To be called under the lock, so that no other process moves or makes this stage meanwhile."""
        place = self.paths.folder(kind, id)
        try:
            record.read(place, verify)
        except FileNotFoundError:
            return None
        except Damage as damage:
            places = (self.paths.folder(kind, f"{id}-{number}", paths.DAMAGED) for number in itertools.count(1))
            target = next(each for each in places if not each.exists())
            target.parent.mkdir(parents=True, exist_ok=True)
            place.rename(target)
            progress.notice(f"{id} was damaged ({damage}); it is kept in {target}")
            return damage
        return None

    def _make(self, stage: Stage, work: Callable[[Path], dict[str, Any]], folder: Path) -> Record:
        folder.mkdir(parents=True, exist_ok=True)
        _drop(folder, lambda name: not _is_checkpoint(name))
        holder = {**lock.holder(), "name": stage.name, "command": stage.command, "log": progress.log_path()}
        write_json(folder / HOLDER_FILE, holder, forced=False)
        meter = provenance.Meter()
        try:
            with progress.collected() as notices:
                summary = work(folder)
            if notices:
                summary = summary | {NOTICES: [*dict.fromkeys([*summary.get(NOTICES, ()), *notices])]}
            summary = plain_copy(summary)
        except Exception as error:
            trouble = disk_trouble(error, self.paths.root)
            if trouble is not None:
                _drop(folder, lambda name: not _is_checkpoint(name))
                raise trouble from error
            (folder / HOLDER_FILE).unlink(missing_ok=True)
            trace = "".join(traceback.format_exception(error))
            failure = Failure(type(error).__name__, str(error), trace, progress.log_path(), stage.command)
            raise StageFailed(self._put(stage, folder, meter, failure=failure)) from error
        try:
            READER.check_unchanged(stage.identity.code)
        except UserError:
            shutil.rmtree(folder)
            raise
        _drop(folder, lambda name: name == HOLDER_FILE or _is_checkpoint(name) or name.endswith(TEMPORARY_SUFFIX))
        files = {}
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            sync(path)
            name = path.relative_to(folder).as_posix()
            files[name] = StoredFile(sha256=file_digest(path), bytes=path.stat().st_size)
        return self._put(stage, folder, meter, summary=summary, files=files)

    def _put(
        self, stage: Stage, folder: Path, meter: provenance.Meter, failure: Failure | None = None, **content: Any
    ) -> Record:
        """Write run.json in the working folder, move the folder to its place, and remove an earlier failure."""
        origin = provenance.describe(stage, self.overrides, self.paths.root / "patches", meter)
        outcome, shelf = (StageOutcome.FAILED, paths.FAILED) if failure else (StageOutcome.OK, "")
        Record(
            stage.id, stage.kind, stage.name, outcome, folder, stage.identity,
            provenance=origin, failure=failure, **content,
        ).write()  # fmt: skip
        place = self.paths.folder(stage.kind, stage.id, shelf)
        shutil.rmtree(self.paths.folder(stage.kind, stage.id, paths.FAILED), ignore_errors=True)
        place.parent.mkdir(parents=True, exist_ok=True)
        folder.rename(place)
        sync(place.parent)
        return record.read(place)


def _drop(folder: Path, unwanted: Callable[[str], bool]) -> None:
    for path in folder.rglob("*"):
        if path.is_file() and unwanted(path.name):
            path.unlink()


def _is_checkpoint(name: str) -> bool:
    return name.startswith(paths.CHECKPOINT_PREFIX) and not name.endswith(TEMPORARY_SUFFIX)
