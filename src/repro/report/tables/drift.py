"""Whether a committed table is what the committed results give: every row, every digit that a machine keeps."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from repro.report.tables.table import Table

# The last digits of a quantile differ between versions of the libraries.
TOLERANCE = 1e-9


def table_drift(path: Path, table: Table, key: Sequence[str]) -> list[str]:
    """Say in which rows, named by their columns `key`, a committed CSV file differs from a table computed anew."""
    if not path.is_file():
        return [f"{path.name} is not there"]
    committed = _rows(path.read_text(encoding="utf-8"), key)
    now = _rows(table.csv(), key)
    differences = []
    for name in dict.fromkeys([*now, *committed]):
        if name not in now or name not in committed:
            differences.append(f"{path.name} {'lacks' if name in now else 'holds'} {name}")
            continue
        differing = [c for c in now[name] if not _same(committed[name].get(c) or "", now[name][c])]
        differences += [f"{path.name} holds another {c} of {name} than {now[name][c] or 'none'}" for c in differing]
    return differences


def _rows(text: str, key: Sequence[str]) -> dict[str, Mapping[str, str]]:
    return {" ".join(row[c] for c in key if row[c]): row for row in csv.DictReader(io.StringIO(text))}


def _same(committed: str, now: str) -> bool:
    try:
        first, second = float(committed), float(now)
    except ValueError:
        return committed == now
    return (
        first == second or math.isclose(first, second, rel_tol=TOLERANCE) or (math.isnan(first) and math.isnan(second))
    )
