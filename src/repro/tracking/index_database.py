"""The index on disk: one SQLite file, one row per stage, written in short transactions.

Several processes may read and write it at once. Where the file system allows no database (no locks, no writing) nothing
is stored, and every run.json is read each time.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from repro.tracking.plain_data import canonical
from repro.tracking.record import StageOutcome

_WAIT_S = 5.0  # for another process that writes the index


@dataclass(frozen=True, slots=True)
class Entry:
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
    upstream: Mapping[str, str] = field(default_factory=dict)
    finished: str = ""
    wall_s: float = 0.0
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


# Time of change and size of a run.json.
Stamp = tuple[int, int]
# By the place of a stage in the store.
Rows = dict[str, tuple[Stamp, Entry]]
# Each distinct code identity (modules, code, libraries) once, by its key.
Codes = dict[str, dict[str, Any]]

_FIELDS = tuple(column.name for column in fields(Entry))
_COLUMNS = ("place", "changed_ns", "bytes", *_FIELDS)
_SCHEMA = (
    f"CREATE TABLE stages ({', '.join(_COLUMNS)}, PRIMARY KEY (place)) WITHOUT ROWID",
    "CREATE TABLE codes (key, text, PRIMARY KEY (key)) WITHOUT ROWID",
)
# A file of another schema is made again.
_FORMAT = int(hashlib.sha256("".join(_SCHEMA).encode()).hexdigest()[:7], 16)


def read(file: Path) -> tuple[Rows, Codes]:
    """All rows and codes; nothing where there is no usable database. A damaged one is removed."""
    if not file.exists():
        return {}, {}
    try:
        with closing(sqlite3.connect(file, timeout=_WAIT_S, isolation_level=None)) as database:
            database.execute("BEGIN")
            if database.execute("PRAGMA user_version").fetchone() != (_FORMAT,):
                return {}, {}
            rows = {
                place: ((changed, size), Entry(id, kind, name, StageOutcome(outcome), json.loads(upstream), *texts))
                for place, changed, size, id, kind, name, outcome, upstream, *texts in database.execute(
                    "SELECT * FROM stages"
                )
            }
            codes = {key: json.loads(text) for key, text in database.execute("SELECT * FROM codes")}
        if not {entry.code for _, entry in rows.values()} <= {"", *codes}:
            raise ValueError("a code identity is missing")
        return rows, codes
    except sqlite3.OperationalError:
        return {}, {}
    except (sqlite3.DatabaseError, ValueError, TypeError):
        for damaged in (file, file.with_name(f"{file.name}-journal")):
            with suppress(OSError):
                damaged.unlink()
        return {}, {}


def save(file: Path, new: Rows, gone: Sequence[str], codes: Codes) -> None:
    """Add or replace rows and remove those of the places `gone`; nothing where the file cannot be written.

    Raises nothing: a cache that cannot be written (read-only results) costs time, no more.
    """
    rows = [(place, *stamp, *_columns(entry)) for place, (stamp, entry) in new.items()]
    texts = [(key, canonical(codes[key]).decode()) for key in {entry.code for _, entry in new.values()} - {""}]
    with suppress(OSError, sqlite3.Error):
        file.parent.mkdir(parents=True, exist_ok=True)
        with closing(sqlite3.connect(file, timeout=_WAIT_S, isolation_level=None)) as database:
            database.execute("BEGIN IMMEDIATE")
            if database.execute("PRAGMA user_version").fetchone() != (_FORMAT,):
                for (table,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall():
                    database.execute(f'DROP TABLE "{table}"')
                for statement in _SCHEMA:
                    database.execute(statement)
                database.execute(f"PRAGMA user_version = {_FORMAT}")
            database.executemany("DELETE FROM stages WHERE place = ?", [(place,) for place in gone])
            values = ", ".join("?" for _ in _COLUMNS)
            database.executemany(f"INSERT OR REPLACE INTO stages VALUES ({values})", rows)
            database.executemany("INSERT OR REPLACE INTO codes VALUES (?, ?)", texts)
            database.execute("DELETE FROM codes WHERE key NOT IN (SELECT code FROM stages)")
            database.execute("COMMIT")


def _columns(entry: Entry) -> Iterator[str | float]:
    for name in _FIELDS:
        value = getattr(entry, name)
        yield json.dumps(dict(value)) if name == "upstream" else value
