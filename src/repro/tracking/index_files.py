"""The index on disk: a folder of Parquet files, a row a stage, where a row of a later file replaces earlier ones.

An update adds one file, so that it costs what is new; when there are many, all rows go into one. Files appear by atomic
rename, and a process removes only files whose rows it has written anew, so that several may do so at once. Whatever a
row that is lost or damaged has told is read again from its run.json.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from repro.tracking.files import write_bytes
from repro.tracking.plain_data import canonical

if TYPE_CHECKING:
    import pyarrow

Stamp = tuple[int, int]

_MOST_FILES = 8
_PLAIN = ("id", "kind", "name", "outcome", "finished", "wall_s", "command", "card_text", "medians_text", "error")


@dataclass(frozen=True)
class Entry:
    """The fields of one run.json that lists need.

    outcome    "ok", "failed" or "damaged" (run.json cannot be read)
    code       key into the codes of the index
    card_text  the card as JSON text, for most lists read it of a few entries only; so are the medians
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
    card_text: str = "{}"
    medians_text: str = "{}"
    error: str = ""

    @property
    def card(self) -> dict[str, Any]:
        """What the work calls its card: plain entries to list and filter by."""
        return dict(json.loads(self.card_text))

    @property
    def medians(self) -> dict[str, Any]:
        """The results by name, medians over the members."""
        return dict(json.loads(self.medians_text))


@dataclass
class Stored:
    """What the files hold.

    rows   by the place of a stage in the store: time of change and size of its run.json, and its entry
    codes  each distinct code identity once, by its key
    files  those that were read
    """

    rows: dict[str, tuple[Stamp, Entry]] = field(default_factory=dict)
    codes: dict[str, dict[str, Any]] = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)


def code_key(code: Mapping[str, Any]) -> str:
    """The key of a code identity."""
    return hashlib.sha256(canonical(code)).hexdigest()[:16]


def read(folder: Path) -> Stored:
    """All rows; a file that is damaged, or of other columns, is removed, and its rows with it."""
    stored = Stored()
    files = sorted(folder.glob("*.parquet"))
    if not files:
        return stored
    from pyarrow import ArrowException
    from pyarrow.parquet import ParquetFile

    for file in files:
        try:
            with ParquetFile(file) as opened:
                rows = dict(_rows(opened.read(use_threads=False), stored.codes))
        except FileNotFoundError:  # another process has just put its rows into a new file
            continue
        except (OSError, ValueError, KeyError, AttributeError, ArrowException):
            with suppress(OSError):
                file.unlink()
            continue
        stored.rows |= rows
        stored.files.append(file)
    return stored


def add(
    folder: Path, stored: Stored, rows: Mapping[str, tuple[Stamp, Entry]], codes: Mapping[str, dict[str, Any]]
) -> None:
    """Bring the files to these rows: add those that are not stored, or write all anew where that has become tidier."""
    new = {key: row for key, row in rows.items() if stored.rows.get(key) is not row}
    tidy = len(stored.files) >= _MOST_FILES or len(stored.rows) > 2 * len(rows)
    if new or tidy:
        _write(folder / f"{time.time_ns():020d}-{os.getpid()}.parquet", rows if tidy else new, codes)
    if tidy:
        for file in stored.files:
            file.unlink(missing_ok=True)


def _rows(table: pyarrow.Table, codes: dict[str, dict[str, Any]]) -> Iterator[tuple[str, tuple[Stamp, Entry]]]:
    columns = {name: table.column(name) for name in table.column_names}
    keys: list[str] = []
    for chunk in columns["code"].chunks:
        each = [json.loads(text) for text in chunk.dictionary.to_pylist()]
        named = [code_key(code) if code else "" for code in each]
        codes.update((key, code) for key, code in zip(named, each, strict=True) if key)
        keys += [named[place] for place in chunk.indices.to_pylist()]
    upstream = json.loads(f"[{','.join(columns['upstream'].to_pylist())}]")
    plain = (columns[name].to_pylist() for name in ("place", "changed_ns", "bytes", *_PLAIN))
    for place, changed, size, *values, key, sources in zip(*plain, keys, upstream, strict=True):
        yield place, ((changed, size), Entry(**dict(zip(_PLAIN, values, strict=True)), code=key, upstream=sources))


def _write(file: Path, rows: Mapping[str, tuple[Stamp, Entry]], codes: Mapping[str, dict[str, Any]]) -> None:
    import pyarrow
    from pyarrow.parquet import write_table

    stamps, entries = [stamp for stamp, _ in rows.values()], [entry for _, entry in rows.values()]
    texts = {key: canonical(codes.get(key, {})).decode() for key in {entry.code for entry in entries}}
    columns: dict[str, Any] = {
        "place": list(rows),
        "changed_ns": pyarrow.array([changed for changed, _ in stamps], pyarrow.int64()),
        "bytes": pyarrow.array([size for _, size in stamps], pyarrow.int64()),
        **{name: [getattr(entry, name) for entry in entries] for name in _PLAIN},
        "code": pyarrow.array([texts[entry.code] for entry in entries]).dictionary_encode(),
        "upstream": [canonical(entry.upstream).decode() for entry in entries],
    }
    sink = pyarrow.BufferOutputStream()
    write_table(pyarrow.table(columns), sink)
    write_bytes(file, sink.getvalue().to_pybytes())
