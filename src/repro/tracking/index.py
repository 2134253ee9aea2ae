"""The index of all run.json files: what lists and looks up runs reads these few fields instead of every file.

Finished stages never change, so a run.json is read once, and again only when its time of change or its size differs.
The index is a cache that can be deleted at any time.
"""

from __future__ import annotations

import hashlib
import json
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from repro.tracking import index_database
from repro.tracking.index_database import Codes, Entry, Rows, Stamp
from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.plain_data import canonical
from repro.tracking.record import StageOutcome

_READERS = 8
_SHELVES = {"": StageOutcome.OK, ".failed": StageOutcome.FAILED}


@dataclass
class Index:
    """All entries, by kind, outcome and id, and each distinct code identity once."""

    entries: list[Entry] = field(default_factory=list)
    codes: Codes = field(default_factory=dict)

    def finished(self) -> dict[str, Entry]:
        """Entries of finished stages by id."""
        return {entry.id: entry for entry in self.entries if entry.outcome is StageOutcome.OK}


def load(paths: Paths) -> Index:
    """The index, brought up to date with the store, and saved where anything changed."""
    stored, codes = index_database.read(paths.index)
    rows: Rows = {}
    unread: list[tuple[str, Stamp, str, str, StageOutcome]] = []
    for kind in paths.kinds():
        for shelf, outcome in _SHELVES.items():
            for id in paths.ids(kind, shelf):
                place = f"{kind}/{shelf}/{id}"
                stamp = _stamp(f"{paths.root}/{place}/{RUN_FILE}")
                row = stored.get(place)
                if row is not None and row[0] == stamp:
                    rows[place] = row
                elif stamp is not None:
                    unread.append((place, stamp, id, kind, outcome))
    # Several files at once, since reading waits for the disk.
    with ThreadPoolExecutor(_READERS) as readers:
        contents = list(readers.map(_content, [paths.root / place / RUN_FILE for place, *_ in unread]))
    new = {
        place: (stamp, _entry(content, id, kind, outcome, codes))
        for (place, stamp, id, kind, outcome), content in zip(unread, contents, strict=True)
    }
    if new or len(stored) > len(rows):
        gone = [place for place in stored if place not in rows and place not in new]
        index_database.save(paths.index, new, gone, codes)
    rows |= new
    return Index([entry for _, (_, entry) in sorted(rows.items(), key=lambda row: row[0])], codes)


def _stamp(file: str) -> Stamp | None:
    """Time of change and size; None without a run.json, which alone makes a folder a stage."""
    try:
        stat = os.stat(file)  # noqa: PTH116 - ten thousand at a time
    except FileNotFoundError:
        return None
    return stat.st_mtime_ns, stat.st_size


def _content(file: Path) -> bytes | OSError:
    try:
        return file.read_bytes()
    except OSError as error:
        return error


def _entry(content: bytes | OSError, id: str, kind: str, outcome: StageOutcome, codes: Codes) -> Entry:
    try:
        if isinstance(content, OSError):
            raise content
        run = json.loads(content)
        identity, origin, error = run["identity"], run["provenance"], run["error"]
        code = {part: identity[part] for part in ("modules", "code", "libraries")}
        key = hashlib.sha256(canonical(code)).hexdigest()[:16]
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
            card_text=json.dumps(run["summary"].get("card", {})),
            medians_text=json.dumps(run["summary"].get("median", {})),
            error=f"{error['type']}: {error['message']}" if error else "",
            upstream=dict(identity["upstream"]),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as trouble:
        return Entry(id, kind, id, StageOutcome.DAMAGED, error=f"{RUN_FILE} cannot be read ({trouble})")
