"""The light commands of the front door: status, runs, clean."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from repro.errors import UserError
from repro.tracking import index
from repro.tracking import status as states
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.stage import Stage
from repro.tracking.text import duration, short, size, table, terminal_width

_MOST_LINES = 15
_MOST_COLUMNS = 6
_RESULTS = ("mae_tau", "mae_qdd", "success")


def status(argv: Sequence[str]) -> int:
    """`repro status`: what is done, stale, failed, missing, running; --why ID names what changed."""
    parser = argparse.ArgumentParser(
        prog="repro status",
        description="What is done, stale (code, libraries or defaults changed), failed, missing, running, interrupted.",
        epilog="example: repro status --why sip-lagrangian-t2-9f3c2a81bd",
    )
    parser.add_argument("--why", metavar="ID", help="name every input of this stage that changed (the id may be cut)")
    parser.add_argument("--all", action="store_true", help="list every stage, not the first few of each state")
    parser.add_argument("--json", action="store_true", help="for other programs")
    parser.add_argument(
        "--verify", action="store_true", help="read every byte of every result; move damaged ones aside"
    )
    options = parser.parse_args(argv)
    paths = Paths(outputs_root())
    items = _survey(paths, options.verify)
    if options.why:
        items = _chosen(items, options.why)
    if options.json:
        print(json.dumps([asdict(item) for item in items], indent=1))
    elif options.why:
        for item in items:
            print(f"{item.id}: {item.state}", *(f"  {line}" for line in item.why), sep="\n")
            print(*([f"  made by: {item.command}"] if item.command else []), sep="\n", end="\n" if item.command else "")
    else:
        _print_status(items, paths, options.all)
    return 0


def _survey(paths: Paths, verify: bool) -> list[states.Item]:
    """The survey; composing a job anew is left to the sweep, which is loaded only when the settings have changed."""

    def expected(overrides: Sequence[str]) -> Sequence[Stage]:
        return list(import_module("repro.sweep").expected_stages(overrides))

    if find_spec("repro.sweep") is None:
        return states.survey(paths, verify=verify)
    settings = import_module("repro.settings").digest if find_spec("repro.settings") else None
    return states.survey(paths, verify=verify, expected=expected, settings=settings)


def _chosen(items: Sequence[states.Item], text: str) -> list[states.Item]:
    exact = [item for item in items if item.id == text]
    fitting = exact or [item for item in items if item.id.startswith(text) or item.id.rpartition("-")[2] == text]
    if not fitting:
        raise UserError(f"no stage {text} is stored or listed; `repro status --all` names them")
    return fitting


def _print_status(items: Sequence[states.Item], paths: Paths, everything: bool) -> None:
    if not items:
        print(f"Nothing in {paths.root} yet; `repro reproduce` fills it.")
        return
    counts = Counter((item.kind, item.state) for item in items)
    kinds = sorted({item.kind for item in items})
    shown = [state for state in states.STATES if any(counts[kind, state] for kind in kinds)]
    print(table([[kind, *(counts[kind, state] or "-" for state in shown)] for kind in kinds], ["", *shown]))
    for state in shown:
        chosen = [item for item in items if item.state == state]
        if state == "done" and not everything:
            continue
        lines = chosen if everything else chosen[:_MOST_LINES]
        print(f"\n{state}")
        print(table([f"  {item.id}", short(item.why[0].partition("\n")[0], 100) if item.why else ""] for item in lines))
        if len(lines) < len(chosen):
            print(f"  ... and {len(chosen) - len(lines)} more (--all)")


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
            *([entry.id] if width is None else [entry.id.rpartition("-")[2], entry.name]),
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


def clean(argv: Sequence[str]) -> int:
    """`repro clean`: remove leftovers; shows first, removes with --yes."""
    from repro.tracking import clean as cleaning

    parser = argparse.ArgumentParser(
        prog="repro clean",
        description="List what can go without losing a current result; with --yes, remove it.",
        epilog="example: repro clean stale --yes",
    )
    parser.add_argument(
        "sorts", nargs="*", metavar="what", help=f"{', '.join(cleaning.SORTS)} (default: all but stale)"
    )
    parser.add_argument("--yes", action="store_true", help="remove them")
    options = parser.parse_args(argv)
    for sort in options.sorts:
        if sort not in cleaning.SORTS:
            raise UserError(f"clean knows no {sort}; choose from {', '.join(cleaning.SORTS)}")
    paths = Paths(outputs_root())
    folders = cleaning.removable(paths, options.sorts or cleaning.USUAL)
    sizes = {folder: cleaning.size_of(folder) for folder in folders}
    gone = list(cleaning.remove(paths, folders)) if options.yes else folders
    for folder in gone:
        print(f"{size(sizes[folder]):>10}  {folder.relative_to(paths.root)}")
    total = size(sum(sizes[folder] for folder in gone))
    print(
        f"{total} removed." if options.yes else f"{total} can be removed: add --yes." if gone else "Nothing to remove."
    )
    return 0
