"""A cache of all run.json files: what lists and looks up runs reads these few fields instead of every file.

Finished stages never change, so a run.json is read once, and again only when its time of change or its size differs.
The file is one JSON text (reading it needs no heavy library) and can be deleted at any time.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from pathlib import Path
from statistics import median
from typing import Any

from repro.tracking.files import digest, write_atomically
from repro.tracking.paths import RUN_FILE, Paths

_FORMAT = 1
_READERS = 8
_BATCH = 64
_SHELVES = {"": "ok", ".failed": "failed"}


@dataclass(frozen=True)
class Entry:
    """The fields of one run.json that lists need.

    outcome  "ok", "failed" or "damaged" (run.json cannot be read)
    code     key into Index.codes
    card     what the work calls its card: plain entries to list and filter by
    """

    id: str
    kind: str
    name: str
    outcome: str
    finished: str = ""
    wall_s: float = 0.0
    command: str = ""
    code: str = ""
    upstream: Mapping[str, str] = field(default_factory=dict)
    card: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""


# A row of the index is the stamp of its file, then the fields of an Entry.
_CODE_PLACE = 1 + [field.name for field in fields(Entry)].index("code")


@dataclass
class Index:
    """All entries, by kind, outcome and id, and each distinct code identity once."""

    entries: list[Entry] = field(default_factory=list)
    codes: dict[str, dict[str, Any]] = field(default_factory=dict)

    def finished(self) -> dict[str, Entry]:
        """Entries of finished stages by id."""
        return {entry.id: entry for entry in self.entries if entry.outcome == "ok"}

    def expected_seconds(self, kind: str, name: str) -> float | None:
        """Median time of the finished stages of this name, else of this kind; None when there are none."""
        finished = [entry for entry in self.entries if entry.outcome == "ok" and entry.kind == kind]
        alike = [entry.wall_s for entry in finished if entry.name == name] or [entry.wall_s for entry in finished]
        return median(alike) if alike else None


def load(paths: Paths) -> Index:
    """The index, brought up to date with the store; saved when anything changed and the store can be written."""
    known_rows, codes = _stored(paths.index)
    rows: dict[str, list[Any]] = {}
    unread: list[tuple[str, list[int], str, str, str]] = []
    for kind in paths.kinds():
        for shelf, outcome in _SHELVES.items():
            for id in paths.ids(kind, shelf):
                key = f"{kind}/{shelf}/{id}"
                stamp = _stamp(f"{paths.root}/{key}/{RUN_FILE}")
                row = known_rows.get(key)
                if row is not None and row[0] == stamp:
                    rows[key] = row
                elif stamp is not None:
                    unread.append((key, stamp, id, kind, outcome))
    contents = _contents([paths.root / key / RUN_FILE for key, *_ in unread])
    for (key, stamp, id, kind, outcome), content in zip(unread, contents, strict=True):
        rows[key] = [stamp, *_row(content, id, kind, outcome, codes)]
    if unread or len(rows) != len(known_rows):
        used = {row[_CODE_PLACE] for row in rows.values()}
        kept = {key: code for key, code in codes.items() if key in used}
        # A cache that cannot be written (read-only results) costs time, nothing else.
        with suppress(OSError):
            stored = {"format": _FORMAT, "rows": rows, "codes": kept}
            write_atomically(paths.index, json.dumps(stored, separators=(",", ":")).encode())
    return Index([Entry(*row[1:]) for _, row in sorted(rows.items())], codes)


def _stored(file: Path) -> tuple[dict[str, list[Any]], dict[str, dict[str, Any]]]:
    try:
        stored = json.loads(file.read_bytes())
        if stored["format"] == _FORMAT:
            return stored["rows"], stored["codes"]
    except (OSError, ValueError, KeyError, TypeError):
        return {}, {}
    return {}, {}


def _stamp(file: str) -> list[int] | None:
    """Time of change and size; None without a run.json, which alone makes a folder a stage."""
    try:
        stat = os.stat(file)  # noqa: PTH116 - ten thousand at a time
    except FileNotFoundError:
        return None
    return [stat.st_mtime_ns, stat.st_size]


def _contents(files: list[Path]) -> list[bytes | OSError]:
    """Reading waits for the disk, so several files are asked for at once."""
    if not files:
        return []
    from concurrent.futures import ThreadPoolExecutor

    batches = [files[start : start + _BATCH] for start in range(0, len(files), _BATCH)]
    with ThreadPoolExecutor(_READERS) as readers:
        return [content for batch in readers.map(_read_batch, batches) for content in batch]


def _read_batch(files: list[Path]) -> list[bytes | OSError]:
    contents: list[bytes | OSError] = []
    for file in files:
        try:
            contents.append(file.read_bytes())
        except OSError as error:
            contents.append(error)
    return contents


def _row(content: bytes | OSError, id: str, kind: str, outcome: str, codes: dict[str, dict[str, Any]]) -> list[Any]:
    """The fields of an Entry, in its order."""
    try:
        if isinstance(content, OSError):
            raise content
        run = json.loads(content)
        identity, origin, error = run["identity"], run["provenance"], run["error"]
        code = {part: identity[part] for part in ("modules", "code", "libraries")}
        key = digest(code)[:16]
        codes[key] = code
        times = (origin["finished"], origin["wall_s"])
        reason = f"{error['type']}: {error['message']}" if error else ""
        card = run["summary"].get("card", {})
        return [id, kind, run["name"], outcome, *times, origin["command"], key, identity["upstream"], card, reason]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as trouble:
        return [id, kind, id, "damaged", "", 0.0, "", "", {}, {}, f"{RUN_FILE} cannot be read ({trouble})"]
