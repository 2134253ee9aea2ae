"""`repro runs`: lists stored runs with the settings in which they differ."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from repro.errors import UserError
from repro.tracking import index
from repro.tracking.ids import digits
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.text import duration, table, terminal_width

_MOST_COLUMNS = 6


_RESULTS = ("mae_tau", "mae_qdd", "success")


def runs(argv: Sequence[str]) -> int:
    """`repro runs`: list stored stages, newest last."""
    parser = argparse.ArgumentParser(
        prog="repro runs",
        description="List stored runs, newest last, with the settings in which they differ.",
        epilog="example: repro runs model=lagrangian basis=t2",
    )
    parser.add_argument("filters", nargs="*", metavar="key=value", help="only runs whose card says so")
    parser.add_argument("--kind", default="runs", help="runs (default), fits, data, recordings, bench, ...")
    parser.add_argument("--json", action="store_true", help="for other programs")
    options = parser.parse_args(argv)
    wishes = _pairs(options.filters)
    entries = [entry for entry in index.load(Paths(outputs_root())).entries if entry.kind == options.kind]
    carded = [(entry, entry.card) for entry in sorted(entries, key=lambda entry: entry.finished)]
    found = [
        (entry, card)
        for entry, card in carded
        if all(str(card.get(key, "")).lower() == value.lower() for key, value in wishes.items())
    ]
    if options.json:
        plain = [asdict(entry) | {"card": card} for entry, card in found]
        print(json.dumps([{key: entry[key] for key in entry if key != "card_text"} for entry in plain], indent=1))
        return 0
    print(_runs_table(found))
    return 0


def _runs_table(found: Sequence[tuple[index.Entry, Mapping[str, Any]]]) -> str:
    """A row a run; a terminal gets the digits at the end of each id, which every command takes, and what fits."""
    width = terminal_width()
    columns = _differing([card for _, card in found])
    medians = [entry.medians for entry, _ in found]
    results = [name for name in _RESULTS if any(name in each for each in medians)]
    failed = ["outcome"] if any(entry.outcome != "ok" for entry, _ in found) else []
    rows = [
        [
            *([entry.id] if width is None else [digits(entry.id), entry.name]),
            *(entry.outcome for _ in failed),
            *(_cell(values.get(name), 3) for name in results),
            *(_cell(card.get(column), 6) for column in columns),
            entry.finished[:16].replace("T", " "),
            duration(entry.wall_s),
        ]
        for (entry, card), values in zip(found, medians, strict=True)
    ]
    names = ["id"] if width is None else ["id", "name"]
    return table(rows, [*names, *failed, *results, *columns, "finished (UTC)", "took"], width)


def _cell(value: object, digits: int) -> object:
    if isinstance(value, bool) or not isinstance(value, float):
        return "" if value is None else str(value).lower() if isinstance(value, bool) else value
    return f"{value:.{digits}g}"


def _pairs(filters: Sequence[str]) -> dict[str, str]:
    for text in filters:
        if "=" not in text:
            raise UserError(f"{text} is no filter; write key=value, e.g. model=lagrangian")
    return dict(text.split("=", 1) for text in filters)


def _differing(cards: Sequence[Mapping[str, Any]]) -> list[str]:
    """The card's plain entries that are not the same in all."""
    keys = [key for key, value in (cards[0] if cards else {}).items() if not isinstance(value, list | Mapping)]
    return [key for key in keys if len({str(card.get(key)) for card in cards}) > 1][:_MOST_COLUMNS]
