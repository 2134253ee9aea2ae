"""The index of all run.json files: what lists and looks up runs reads these few fields instead of every file.

Finished stages never change, so a run.json is read once, and again only when its time of change or its size differs.
The index is a cache in one SQLite file that can be deleted at any time. Only what has changed is written, in one short
transaction. Where it cannot be written (read-only results, a file system without locks) nothing is stored, and every
run.json is read each time.
"""

import json
import os
import sqlite3
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.plain_data import digest
from repro.tracking.record import StageOutcome

_SHELVES = {"": StageOutcome.OK, ".failed": StageOutcome.FAILED}


class Entry(NamedTuple):
    """The fields of one run.json that lists need.

    outcome    DAMAGED where run.json cannot be read; `error` then says why
    upstream   role -> id of each stage that it was made from
    code       key into the codes of the index
    card_text  the card as JSON text, since most lists read it of a few entries only; so are the medians
    """

    id: str
    kind: str
    name: str
    outcome: StageOutcome
    upstream: dict[str, str]
    finished: str = ""
    wall_s: float = 0.0
    peak_memory_mib: float = 0.0
    command: str = ""
    code: str = ""
    card_text: str = "{}"
    medians_text: str = "{}"
    error: str = ""

    @property
    def card(self) -> dict[str, Any]:
        """The card of its summary: plain entries to list and filter by."""
        return dict(json.loads(self.card_text))

    @property
    def medians(self) -> dict[str, Any]:
        """The results by name, medians over the members."""
        return dict(json.loads(self.medians_text))


_TABLES = """
CREATE TABLE IF NOT EXISTS stages (place TEXT PRIMARY KEY, changed_ns INTEGER, size INTEGER, entry TEXT);
CREATE TABLE IF NOT EXISTS codes (key TEXT PRIMARY KEY, code TEXT);
"""
# A file of other fields is made again.
_FORMAT = int(digest(Entry._fields)[:7], 16)
_LONGEST_WAIT_S = 5.0  # for another process that writes
# Time of change in ns and size of a run.json.
Stamp = tuple[int, int]
# By the place of a stage in the store.
Rows = dict[str, tuple[Stamp, Entry]]
# Each distinct code identity (modules, code, libraries) once, by its key.
Codes = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Index:
    """All entries, by kind, outcome and id, and each distinct code identity once."""

    entries: list[Entry]
    codes: Codes

    def finished(self) -> dict[str, Entry]:
        """Entries of finished stages by id."""
        return {entry.id: entry for entry in self.entries if entry.outcome is StageOutcome.OK}


def load(paths: Paths) -> Index:
    """The index, brought up to date with the store, and saved where anything changed."""
    stored, codes = _read(paths.index)
    rows: Rows = {}
    for kind in paths.kinds():
        for shelf, outcome in _SHELVES.items():
            for id in paths.ids(kind, shelf):
                place = f"{kind}/{shelf}/{id}"
                stamp = _stamp(f"{paths.root}/{place}/{RUN_FILE}")
                if stamp is not None and place in stored and stored[place][0] == stamp:
                    rows[place] = stored[place]
                elif stamp is not None:
                    rows[place] = stamp, _entry(paths.root / place / RUN_FILE, id, kind, outcome, codes)
    codes = {key: codes[key] for key in sorted({entry.code for _, entry in rows.values()} - {""})}
    if rows != stored:
        # A cache that cannot be written costs time, no more.
        with suppress(OSError, sqlite3.Error):
            _write(paths.index, rows, stored, codes)
    return Index([entry for _, (_, entry) in sorted(rows.items(), key=lambda row: row[0])], codes)


def _read(file: Path) -> tuple[Rows, Codes]:
    """The rows and codes of the file; none where it is missing, damaged, locked for long or of another format."""
    try:
        with closing(sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True, timeout=_LONGEST_WAIT_S)) as index:
            (version,) = index.execute("PRAGMA user_version").fetchone()
            if version != _FORMAT:
                return {}, {}
            codes = {key: json.loads(code) for key, code in index.execute("SELECT key, code FROM codes")}
            rows: Rows = {}
            for place, changed_ns, size, entry in index.execute("SELECT place, changed_ns, size, entry FROM stages"):
                id, kind, name, outcome, *values = json.loads(entry)
                rows[place] = (changed_ns, size), Entry(id, kind, name, StageOutcome(outcome), *values)
    except (OSError, sqlite3.Error, ValueError, TypeError):
        return {}, {}
    whole = {entry.code for _, entry in rows.values()} <= {"", *codes}
    return (rows, codes) if whole else ({}, {})


def _write(file: Path, rows: Rows, stored: Rows, codes: Codes) -> None:
    """Write what differs from the stored rows; a file that holds none (damaged, foreign) is made anew."""
    file.parent.mkdir(parents=True, exist_ok=True)
    if not stored:
        file.unlink(missing_ok=True)
    changed = [
        (place, *stamp, json.dumps(entry)) for place, (stamp, entry) in rows.items() if stored.get(place) != rows[place]
    ]
    with closing(sqlite3.connect(file, timeout=_LONGEST_WAIT_S)) as index:
        index.executescript(f"{_TABLES} PRAGMA user_version = {_FORMAT};")
        with index:
            index.executemany("DELETE FROM stages WHERE place = ?", [(place,) for place in stored.keys() - rows.keys()])
            index.executemany("REPLACE INTO stages VALUES (?, ?, ?, ?)", changed)
            index.executemany("REPLACE INTO codes VALUES (?, ?)", [(key, json.dumps(codes[key])) for key in codes])


def _stamp(file: str) -> Stamp | None:
    """Time of change and size; None without a run.json, which alone makes a folder a stage."""
    try:
        stat = os.stat(file)  # noqa: PTH116 - ten thousand at a time
    except FileNotFoundError:
        return None
    return stat.st_mtime_ns, stat.st_size


def _entry(file: Path, id: str, kind: str, outcome: StageOutcome, codes: Codes) -> Entry:
    try:
        run = json.loads(file.read_bytes())
        identity, origin, error = run["identity"], run["provenance"], run["error"]
        code = {part: identity[part] for part in ("modules", "code", "libraries")}
        key = digest(code)[:16]
        codes[key] = code
        return Entry(
            id,
            kind,
            run["name"],
            outcome,
            upstream=dict(identity["upstream"]),
            finished=origin["finished"],
            wall_s=float(origin["wall_s"]),
            peak_memory_mib=float(origin["peak_memory_mib"]),
            command=origin["command"],
            code=key,
            card_text=json.dumps(run["summary"].get("card", {})),
            medians_text=json.dumps(run["summary"].get("median", {})),
            error=f"{error['type']}: {error['message']}" if error else "",
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as trouble:
        return Entry(id, kind, id, StageOutcome.DAMAGED, {}, error=f"{RUN_FILE} cannot be read ({trouble})")
