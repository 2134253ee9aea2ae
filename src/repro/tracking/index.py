"""The index of all run.json files: what lists and looks up runs reads these few fields instead of every file.

Finished stages never change, so a run.json is read once, and again only when its time of change or its size differs.
The index is a cache that can be deleted at any time.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

from repro.tracking import index_files
from repro.tracking.index_files import Entry, Stamp
from repro.tracking.paths import RUN_FILE, Paths

_READERS = 8
_BATCH = 64
_SHELVES = {"": "ok", ".failed": "failed"}


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
    stored = index_files.read(paths.index)
    codes = stored.codes
    rows: dict[str, tuple[Stamp, Entry]] = {}
    unread: list[tuple[str, Stamp, str, str, str]] = []
    for kind in paths.kinds():
        for shelf, outcome in _SHELVES.items():
            for id in paths.ids(kind, shelf):
                place = f"{kind}/{shelf}/{id}"
                stamp = _stamp(f"{paths.root}/{place}/{RUN_FILE}")
                row = stored.rows.get(place)
                if row is not None and row[0] == stamp:
                    rows[place] = row
                elif stamp is not None:
                    unread.append((place, stamp, id, kind, outcome))
    contents = _contents([paths.root / place / RUN_FILE for place, *_ in unread])
    for (place, stamp, id, kind, outcome), content in zip(unread, contents, strict=True):
        rows[place] = stamp, _entry(content, id, kind, outcome, codes)
    # A cache that cannot be written (read-only results) costs time, nothing else.
    with suppress(OSError):
        index_files.add(paths.index, stored, rows, codes)
    return Index([entry for _, (_, entry) in sorted(rows.items(), key=lambda row: row[0])], codes)


def _stamp(file: str) -> Stamp | None:
    """Time of change and size; None without a run.json, which alone makes a folder a stage."""
    try:
        stat = os.stat(file)  # noqa: PTH116 - ten thousand at a time
    except FileNotFoundError:
        return None
    return stat.st_mtime_ns, stat.st_size


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


def _entry(content: bytes | OSError, id: str, kind: str, outcome: str, codes: dict[str, dict[str, Any]]) -> Entry:
    try:
        if isinstance(content, OSError):
            raise content
        run = json.loads(content)
        identity, origin, error = run["identity"], run["provenance"], run["error"]
        code = {part: identity[part] for part in ("modules", "code", "libraries")}
        key = index_files.code_key(code)
        codes[key] = code
        return Entry(
            id,
            kind,
            run["name"],
            outcome,
            finished=origin["finished"],
            wall_s=float(origin["wall_s"]),
            command=origin["command"],
            code=key,
            upstream=identity["upstream"],
            card_text=json.dumps(run["summary"].get("card", {})),
            medians_text=json.dumps(run["summary"].get("median", {})),
            error=f"{error['type']}: {error['message']}" if error else "",
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as trouble:
        return Entry(id, kind, id, "damaged", error=f"{RUN_FILE} cannot be read ({trouble})")
