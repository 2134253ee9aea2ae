"""A finished or failed stage as it lies in the store."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from repro.errors import UserError
from repro.tracking.files import file_digest, write_json
from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.plain_data import digest

if TYPE_CHECKING:
    import pandas as pd


class StageOutcome(StrEnum):
    """How a stage ended. An index adds DAMAGED: its run.json cannot be read."""

    OK = "ok"
    FAILED = "failed"
    DAMAGED = "damaged"


@dataclass(frozen=True)
class Identity:
    """All that a result depends on.

    config     resolved configuration of the stage alone
    upstream   role -> id of each stage whose result it reads
    code       module -> digest of its syntax tree
    libraries  library -> version
    modules    where the code starts
    """

    config: Mapping[str, Any] = field(default_factory=dict)
    upstream: Mapping[str, str] = field(default_factory=dict)
    code: Mapping[str, str] = field(default_factory=dict)
    libraries: Mapping[str, str] = field(default_factory=dict)
    modules: tuple[str, ...] = ()


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from; times are UTC in ISO 8601, memory is the peak of the process so far."""

    command: str = ""
    overrides: tuple[str, ...] = ()
    seeds: Mapping[str, Any] = field(default_factory=dict)
    started: str = ""
    finished: str = ""
    wall_s: float = 0.0
    cpu_s: float = 0.0
    peak_memory_mib: float = 0.0
    git: Mapping[str, Any] = field(default_factory=dict)
    machine: Mapping[str, Any] = field(default_factory=dict)
    threads: Mapping[str, Any] = field(default_factory=dict)
    torch: Mapping[str, Any] | None = None
    upstream: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class StoredFile:
    """A file of a stage as it was written."""

    sha256: str
    bytes: int


@dataclass(frozen=True)
class Failure:
    """The exception that ended a stage; `log` is the file that took the printed output, "" for the terminal."""

    type: str
    message: str
    trace: str = ""
    log: str = ""
    command: str = ""


@dataclass(frozen=True)
class Record:
    """A stored stage: the content of its run.json, and what lies beside it.

    folder   where the stage lies
    summary  the work's own result, plain data
    files    by name
    failure  None unless the outcome is FAILED
    """

    id: str
    kind: str
    name: str
    outcome: StageOutcome
    folder: Path
    identity: Identity
    summary: Mapping[str, Any] = field(default_factory=dict)
    provenance: Provenance = field(default_factory=Provenance)
    files: Mapping[str, StoredFile] = field(default_factory=dict)
    failure: Failure | None = None

    def path(self, filename: str) -> Path:
        """Full path of one of its files."""
        return self.folder / filename

    @property
    def upstream(self) -> "dict[str, Record]":
        """Role -> the stage its data, fit, ... came from; UserError for one that was deleted or is damaged."""
        paths, stages = Paths(self.folder.parent.parent), {}
        for role, id in self.identity.upstream.items():
            folders = [folder for kind in paths.kinds() if (folder := paths.folder(kind, id)).is_dir()]
            if not folders:
                again = f"this makes it again: {self.provenance.command}"
                raise UserError(f"{id}, the {role} of {self.id}, was deleted; {again}")
            stages[role] = opened(folders[0])
        return stages

    def table(self, name: str) -> "pd.DataFrame":
        """A Parquet file of its folder: "metrics", "curves", "trajectories", ... UserError for an unknown one."""
        import pandas as pd

        file = self.path(f"{name}.parquet")
        if not file.is_file():
            tables = ", ".join(sorted(path.stem for path in self.folder.glob("*.parquet"))) or "none"
            raise UserError(f"{self.id} has no table {name}; it has: {tables}")
        return pd.read_parquet(file)

    def write(self) -> None:
        """Write run.json, the very last file of a stage, with a checksum of its own content."""
        content = asdict(self)
        del content["folder"]
        content["error"] = content.pop("failure")
        write_json(self.folder / RUN_FILE, {**content, "checksum": digest(content)})

    @classmethod
    def of(cls, folder: Path, content: Mapping[str, Any]) -> Self:
        """The record of a folder from the content of its run.json; entries that only another version has are left out.

        Raises KeyError, TypeError or ValueError for what is none.
        """
        from repro.plugins.checked import validated  # takes longer to load than most commands need

        record: Self = validated(cls, RUN_FILE, {**content, "folder": folder, "failure": content["error"]})
        return record


def prepare() -> None:
    """Make what checks records, for all processes forked from here: it takes as long as a small stage."""
    from repro.plugins.checked import adapter

    adapter(Record)


class Damage(Exception):  # noqa: N818 - a finding about a folder, not a programming error
    """What is wrong with a stored stage."""


def opened(folder: Path) -> Record:
    """The stage in a folder; UserError for a damaged one."""
    try:
        return read(folder)
    except Damage as damage:
        raise UserError(f"{folder} is damaged ({damage}): run the command that made it again") from damage


def read(folder: Path, verify: bool = False) -> Record:
    """Read and check run.json: its own checksum, its files' presence and sizes, and with `verify` every byte of them.

    Raises FileNotFoundError when the folder does not exist and Damage when anything differs from what was written.
    """
    try:
        content = json.loads((folder / RUN_FILE).read_bytes())
        stored = content.pop("checksum")
        record = Record.of(folder, content)
    except FileNotFoundError as error:
        if not folder.is_dir():
            raise
        raise Damage(f"{RUN_FILE} is missing") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise Damage(f"{RUN_FILE} cannot be read ({'; '.join(str(error).splitlines())})") from error
    if stored != digest(content):
        raise Damage(f"{RUN_FILE} differs from its checksum")
    for path, expected in ((folder / name, expected) for name, expected in record.files.items()):
        if not path.is_file():
            raise Damage(f"{path.name} is missing")
        if path.stat().st_size != expected.bytes:
            raise Damage(f"{path.name} has {path.stat().st_size} bytes instead of {expected.bytes}")
        if verify and file_digest(path) != expected.sha256:
            raise Damage(f"{path.name} differs from its checksum")
    return record
