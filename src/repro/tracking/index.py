"""A cache of all run.json files: what lists and looks up runs reads these few fields instead of every file.

Finished stages never change, so a run.json is read once, and again only when its time of change or its size differs.
The file is one JSON text (reading it needs no heavy library) and can be deleted at any time.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from repro.tracking.files import digest, write_atomically
from repro.tracking.paths import RUN_FILE, Paths

_FORMAT = 1
_SHELVES = {"": "ok", ".failed": "failed"}


@dataclass(frozen=True)
class Entry:
    """The fields of one run.json that lists need.

    outcome  "ok", "failed" or "damaged" (run.json cannot be read)
    code     key into Index.codes
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


@dataclass
class Index:
    """All entries by (kind, outcome, id), and each distinct code identity once."""

    entries: list[Entry] = field(default_factory=list)
    codes: dict[str, dict[str, Any]] = field(default_factory=dict)

    def finished(self) -> dict[str, Entry]:
        """Entries of finished stages by id."""
        return {entry.id: entry for entry in self.entries if entry.outcome == "ok"}


def load(paths: Paths) -> Index:
    """The index, brought up to date with the store; saved when anything changed and the store can be written."""
    known = _stored(paths.index)
    fresh: dict[str, list[Any]] = {}
    codes: dict[str, dict[str, Any]] = {}
    changed = False
    for kind in paths.kinds():
        for shelf, outcome in _SHELVES.items():
            for id in paths.ids(kind, shelf):
                file = os.path.join(paths.root, kind, shelf, id, RUN_FILE)  # noqa: PTH118 - ten thousand at a time
                stamp = _stamp(file)
                key = f"{kind}/{shelf}/{id}"
                row = known["rows"].get(key)
                if row is None or row[0] != stamp:
                    row = [stamp, *_read(Path(file), id, kind, outcome, known["codes"])]
                    changed = True
                fresh[key] = row
                codes[row[1]["code"]] = known["codes"].get(row[1]["code"], {})
    if changed or len(fresh) != len(known["rows"]):
        # A cache that cannot be written (read-only results) costs time, nothing else.
        with suppress(OSError):
            content = {"format": _FORMAT, "rows": fresh, "codes": codes}
            write_atomically(paths.index, json.dumps(content, separators=(",", ":")).encode())
    return Index([Entry(**row[1]) for row in fresh.values()], codes)


def _stored(file: Path) -> dict[str, Any]:
    try:
        stored = json.loads(file.read_bytes())
        if stored["format"] == _FORMAT:
            return dict(stored)
    except (OSError, ValueError, KeyError, TypeError):
        return {"rows": {}, "codes": {}}
    return {"rows": {}, "codes": {}}


def _stamp(file: str) -> list[int]:
    try:
        stat = os.stat(file)  # noqa: PTH116 - ten thousand at a time
    except FileNotFoundError:
        return [0, 0]
    return [stat.st_mtime_ns, stat.st_size]


def _read(file: Path, id: str, kind: str, outcome: str, codes: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    try:
        run = json.loads(file.read_bytes())
        identity = run["identity"]
        code = {part: identity[part] for part in ("modules", "code", "libraries")}
        key = digest(code)[:16]
        codes[key] = code
        card = run["summary"].get("card", {})
        error = run["error"]
        row = {
            "id": id,
            "kind": kind,
            "name": run["name"],
            "outcome": outcome,
            "finished": run["provenance"]["finished"],
            "wall_s": run["provenance"]["wall_s"],
            "command": run["provenance"]["command"],
            "code": key,
            "upstream": identity["upstream"],
            "card": card,
            "error": f"{error['type']}: {error['message']}" if error else "",
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as trouble:
        row = {"id": id, "kind": kind, "name": id, "outcome": "damaged", "code": "", "error": f"{RUN_FILE}: {trouble}"}
    return [row]
