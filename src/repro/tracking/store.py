"""The store of finished stages: never a half one, never a stale one, never the same work twice."""

from __future__ import annotations

import shutil
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from repro.errors import UserError
from repro.tracking import lock, progress, provenance, record
from repro.tracking.files import disk_errors_explained, disk_trouble, file_digest, sync, write_json
from repro.tracking.paths import CHECKPOINT_PREFIX, HOLDER_FILE, RUN_FILE, TEMPORARY_SUFFIX, Paths
from repro.tracking.plain_data import plain_copy
from repro.tracking.record import Damage, Failure, Record, StageOutcome, StoredFile
from repro.tracking.source_reader import READER
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

    def find(self, id: str, *, kind: str = "", verify: bool = False) -> Record | None:
        """The finished stage of an id, or None when it is missing or damaged.

        Checks run.json and the sizes of the files; `verify` checks every byte.
        """
        return self._first(self.paths.folder, id, kind, verify)

    def has(self, id: str, kind: str) -> bool:
        """Whether a finished stage lies in its folder, unread."""
        return (self.paths.folder(kind, id) / RUN_FILE).is_file()

    def failure(self, id: str, *, kind: str = "") -> Record | None:
        """The last failed attempt of an id, or None; a success replaces it."""
        return self._first(self.paths.failed, id, kind)

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
        folder = self.paths.work(stage.kind, stage.id)
        with (
            disk_errors_explained(self.paths.root),
            lock.held(self.paths.lock(stage.kind, stage.id), folder / HOLDER_FILE, stage.id),
        ):
            self._move_aside_if_damaged(stage.kind, stage.id)
            stored = self.find(stage.id, kind=stage.kind)
            return stored if stored is not None else self._make(stage, work, folder)

    def verify(self, kind: str, id: str) -> Damage | None:
        """Check every byte of a finished stage; a damaged one is moved aside, so that its command makes it again."""
        holder = self.paths.work(kind, id) / HOLDER_FILE
        with disk_errors_explained(self.paths.root):
            try:
                record.read(self.paths.folder(kind, id), verify=True)
            except FileNotFoundError:
                return None
            except Damage:
                with lock.held(self.paths.lock(kind, id), holder, id):
                    return self._move_aside_if_damaged(kind, id, verify=True)
        return None

    def _first(self, place: Callable[[str, str], Path], id: str, kind: str, verify: bool = False) -> Record | None:
        for candidate in [kind] if kind else self.paths.kinds():
            with suppress(FileNotFoundError, Damage):
                return record.read(place(candidate, id), verify)
        return None

    def _move_aside_if_damaged(self, kind: str, id: str, *, verify: bool = False) -> Damage | None:
        """To be called under the lock, so that no other process moves or makes this stage meanwhile."""
        place = self.paths.folder(kind, id)
        try:
            record.read(place, verify)
        except FileNotFoundError:
            return None
        except Damage as damage:
            shelf = self.paths.damaged(kind)
            shelf.mkdir(parents=True, exist_ok=True)
            target = next(name for number in range(1, 10**6) if not (name := shelf / f"{id}-{number}").exists())
            place.rename(target)
            progress.notice(f"{id} was damaged ({damage}); it is kept in {target}")
            return damage
        return None

    def _make(self, stage: Stage, work: Callable[[Path], dict[str, Any]], folder: Path) -> Record:
        folder.mkdir(parents=True, exist_ok=True)
        _drop(folder, lambda name: not _is_checkpoint(name))
        holder = {**lock.holder(), "name": stage.name, "command": stage.command, "log": progress.log_path()}
        write_json(folder / HOLDER_FILE, holder)
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
            raise StageFailed(self._keep_failure(stage, folder, meter, error)) from error
        try:
            READER.check_unchanged(stage.identity.code)
        except UserError:
            shutil.rmtree(folder)
            raise
        return self._keep(stage, folder, meter, summary)

    def _keep(self, stage: Stage, folder: Path, meter: provenance.Meter, summary: dict[str, Any]) -> Record:
        _drop(folder, lambda name: name == HOLDER_FILE or _is_checkpoint(name) or name.endswith(TEMPORARY_SUFFIX))
        files = {}
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            sync(path)
            name = path.relative_to(folder).as_posix()
            files[name] = StoredFile(sha256=file_digest(path), bytes=path.stat().st_size)
        place = self.paths.folder(stage.kind, stage.id)
        finished = self._put(stage, folder, place, StageOutcome.OK, meter, summary=summary, files=files)
        shutil.rmtree(self.paths.failed(stage.kind, stage.id), ignore_errors=True)
        return finished

    def _keep_failure(self, stage: Stage, folder: Path, meter: provenance.Meter, error: Exception) -> Record:
        place = self.paths.failed(stage.kind, stage.id)
        shutil.rmtree(place, ignore_errors=True)
        place.parent.mkdir(parents=True, exist_ok=True)
        (folder / HOLDER_FILE).unlink(missing_ok=True)
        trace = "".join(traceback.format_exception(error))
        failure = Failure(type(error).__name__, str(error), trace, progress.log_path(), stage.command)
        return self._put(stage, folder, place, StageOutcome.FAILED, meter, failure=failure)

    def _put(
        self, stage: Stage, folder: Path, place: Path, outcome: StageOutcome, meter: provenance.Meter, **content: Any
    ) -> Record:
        """Write run.json in the working folder, and move the folder to its place."""
        origin = provenance.describe(stage, self.overrides, self.paths.patches, meter)
        Record(stage.id, stage.kind, stage.name, outcome, folder, stage.identity, provenance=origin, **content).write()
        folder.rename(place)
        sync(place.parent)
        return record.read(place)


def _drop(folder: Path, unwanted: Callable[[str], bool]) -> None:
    for path in folder.rglob("*"):
        if path.is_file() and unwanted(path.name):
            path.unlink()


def _is_checkpoint(name: str) -> bool:
    return name.startswith(CHECKPOINT_PREFIX) and not name.endswith(TEMPORARY_SUFFIX)
