"""The index of all run.json files: what lists and looks up runs reads these few fields instead of every file.

Finished stages never change, so a run.json is read once, and again only when its time of change or its size differs.
The index is a cache: where it cannot be written every run.json is read each time.
"""

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from repro.tracking.cache import Cache
from repro.tracking.paths import RUN_FILE, Paths
from repro.tracking.plain_data import digest
from repro.tracking.record import StageOutcome

_CODE = "code "  # before the key of a code identity in the cache, whose other names are places in the store
_SHELVES = {"": StageOutcome.OK, ".failed": StageOutcome.FAILED}


class Entry(NamedTuple):
    """The fields of one run.json that lists need."""

    id: str
    kind: str
    name: str
    outcome: StageOutcome  # DAMAGED where run.json cannot be read; `error` then says why
    upstream: dict[str, str]  # role -> id of each stage that it was made from
    finished: str = ""
    wall_s: float = 0.0
    peak_memory_mib: float = 0.0
    command: str = ""
    code: str = ""  # key into the codes of the index
    card_text: str = "{}"  # the card as JSON text, since most lists read it of a few entries only; so are the medians
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
    cache = Cache(paths.index, Entry._fields)
    codes = {name.removeprefix(_CODE): code for name, code in cache.values.items() if name.startswith(_CODE)}
    entries: dict[str, Entry] = {}
    for kind in paths.kinds():
        for shelf, outcome in _SHELVES.items():
            for id in paths.ids(kind, shelf):
                place = f"{kind}/{shelf}/{id}"
                stamp = _stamp(f"{paths.root}/{place}/{RUN_FILE}")
                if stamp is None:
                    continue
                entry = _stored(cache.values.get(place), stamp, codes)
                if entry is None:
                    entry = _entry(paths.root / place / RUN_FILE, id, kind, outcome, codes)
                    cache.values[place] = [stamp, entry]
                entries[place] = entry
    codes = {key: codes[key] for key in sorted({entry.code for entry in entries.values()} - {""})}
    cache.values.update((f"{_CODE}{key}", code) for key, code in codes.items())
    cache.retain({*entries, *(f"{_CODE}{key}" for key in codes)})
    cache.save()
    return Index([entries[place] for place in sorted(entries)], codes)


def _stored(value: Any, stamp: list[int], codes: Codes) -> Entry | None:
    """The entry in the cache, where it is one of the same run.json and its code identity is there too."""
    try:
        known, (id, kind, name, outcome, *others) = value
        entry = Entry(id, kind, name, StageOutcome(outcome), *others)
        return entry if known == stamp and (not entry.code or entry.code in codes) else None
    except (ValueError, TypeError):
        return None


def _stamp(file: str) -> list[int] | None:
    """Time of change and size; None without a run.json, which alone makes a folder a stage."""
    try:
        stat = os.stat(file)  # noqa: PTH116 - ten thousand at a time
    except FileNotFoundError:
        return None
    return [stat.st_mtime_ns, stat.st_size]  # a list, as it reads back from the cache


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
