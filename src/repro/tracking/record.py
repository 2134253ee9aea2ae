"""A finished or failed stage as it lies in the store."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from repro.tracking.files import file_digest, write_json
from repro.tracking.paths import RUN_FILE
from repro.tracking.plain_data import digest


@dataclass(frozen=True)
class Record:
    """What run.json says about one stage.

    outcome    "ok" or "failed"
    folder     where it lies
    identity   config, upstream, code, libraries, modules: all that the result depends on
    summary    the work's own result, plain data
    files      file name -> {"sha256", "bytes"}
    error      of a failure: {"type", "message", "trace", "log", "command"}; None otherwise
    """

    id: str
    kind: str
    name: str
    outcome: str
    folder: Path
    identity: Mapping[str, Any]
    summary: Mapping[str, Any] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    error: Mapping[str, Any] | None = None

    def path(self, filename: str) -> Path:
        """Full path of one of its files."""
        return self.folder / filename

    def write(self) -> None:
        """Write run.json, the very last file of a stage, with a checksum of its own content."""
        content = {
            "id": self.id,
            "kind": self.kind,
            "name": self.name,
            "outcome": self.outcome,
            "identity": self.identity,
            "summary": self.summary,
            "provenance": self.provenance,
            "files": self.files,
            "error": self.error,
        }
        write_json(self.folder / RUN_FILE, {**content, "checksum": digest(content)})


class Damage(Exception):  # noqa: N818 - a finding about a folder, not a programming error
    """What is wrong with a stored stage."""


def read(folder: Path, verify: bool = False) -> Record:
    """Read and check run.json: its own checksum, its files' presence and sizes, and with `verify` every byte of them.

    Raises FileNotFoundError when the folder does not exist and Damage when anything differs from what was written.
    """
    try:
        content = json.loads((folder / RUN_FILE).read_bytes())
        stored = content.pop("checksum")
        record = Record(folder=folder, **content)
    except FileNotFoundError as error:
        if not folder.is_dir():
            raise
        raise Damage(f"{RUN_FILE} is missing") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise Damage(f"{RUN_FILE} cannot be read ({error})") from error
    if stored != digest(content):
        raise Damage(f"{RUN_FILE} differs from its checksum")
    for name, expected in record.files.items():
        _check_file(folder / name, expected, verify)
    return record


def _check_file(path: Path, expected: Mapping[str, Any], verify: bool) -> None:
    if not path.is_file():
        raise Damage(f"{path.name} is missing")
    if path.stat().st_size != expected["bytes"]:
        raise Damage(f"{path.name} has {path.stat().st_size} bytes instead of {expected['bytes']}")
    if verify and file_digest(path) != expected["sha256"]:
        raise Damage(f"{path.name} differs from its checksum")
