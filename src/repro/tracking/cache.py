"""Caches: plain data in SQLite files that may be deleted at any time."""

import json
import sqlite3
from collections.abc import Collection
from contextlib import closing, suppress
from functools import cached_property
from pathlib import Path
from typing import Any

from repro.tracking.plain_data import digest

_LONGEST_WAIT_S = 5.0  # for another process that writes


class Cache:
    """Plain data by name, of one `version` of what it is made from; without a file nothing is stored.

    Only what has changed is written, in one short transaction. A file that is missing, damaged, of another version or
    locked for long, or that cannot be written (read-only results), costs time, nothing else.
    """

    def __init__(self, file: Path | None, version: object) -> None:
        self.file = file
        self._version = ("version", digest(version))
        self._stored: dict[str, Any] = {}

    @cached_property
    def values(self) -> dict[str, Any]:
        """What the file holds; to be changed in place, but each value as a whole."""
        try:
            place = f"{self.file.resolve().as_uri()}?mode=ro" if self.file is not None else ":memory:"
            with closing(sqlite3.connect(place, uri=True, timeout=_LONGEST_WAIT_S)) as database:
                texts = dict(database.execute("SELECT name, value FROM entries").fetchall())
            if texts.pop("version") == self._version[1]:
                values = json.loads(f"[{','.join(texts.values())}]")  # at once, which takes half the time
                self._stored = dict(zip(texts, values, strict=True))
        except (OSError, sqlite3.Error, LookupError, ValueError, TypeError):
            self._stored = {}
        return dict(self._stored)

    @property
    def changed(self) -> dict[str, Any]:
        """The values that the file does not hold."""
        before = self._stored
        return {name: value for name, value in self.values.items() if name not in before or before[name] is not value}

    def retain(self, names: Collection[str]) -> None:
        """Drop all other values."""
        for name in self.values.keys() - names:
            del self.values[name]

    def save(self) -> None:
        """Write what differs from the file; one that holds nothing (damaged, foreign) is made anew."""
        changed, gone = self.changed, self._stored.keys() - self.values.keys()
        if self.file is None or not (changed or gone):
            return
        rows = [self._version, *((name, json.dumps(value)) for name, value in changed.items())]
        with suppress(OSError, sqlite3.Error):
            self.file.parent.mkdir(parents=True, exist_ok=True)
            if not self._stored:
                # A journal that a killed process has left would be taken for one of the new file.
                for file in (self.file, self.file.with_name(f"{self.file.name}-journal")):
                    file.unlink(missing_ok=True)
            with closing(sqlite3.connect(self.file, timeout=_LONGEST_WAIT_S)) as database, database:
                database.execute("PRAGMA synchronous = OFF")  # a cache need not outlive a power failure
                database.execute("CREATE TABLE IF NOT EXISTS entries (name TEXT PRIMARY KEY, value TEXT)")
                database.executemany("DELETE FROM entries WHERE name = ?", [(name,) for name in gone])
                database.executemany("REPLACE INTO entries VALUES (?, ?)", rows)
        self._stored = dict(self.values)
