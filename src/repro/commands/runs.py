"""`repro runs`: lists stored runs with the settings in which they differ."""

import json
from argparse import Namespace
from collections.abc import Mapping, Sequence

from repro.commands.arguments import selected
from repro.tracking import index
from repro.tracking.index import Entry
from repro.tracking.load import digits
from repro.tracking.paths import Paths, outputs_root
from repro.tracking.text import duration, table, terminal_width

_MOST_COLUMNS = 6
_RESULTS = ("mae_tau", "mae_qdd", "success")

Card = Mapping[str, object]


def main(arguments: Namespace) -> int:
    """List stored stages, newest last."""
    entries = [entry for entry in index.load(Paths(outputs_root())).entries if entry.kind == arguments.kind]
    chosen = selected(sorted(entries, key=lambda entry: entry.finished), arguments.filters)
    if arguments.json:
        plain = [entry._asdict() | {"card": card} for entry, card in chosen]
        print(json.dumps([{key: entry[key] for key in entry if key != "card_text"} for entry in plain], indent=1))
    else:
        print(_runs_table(chosen))
    return 0


def _runs_table(runs: Sequence[tuple[Entry, Card]]) -> str:
    """One row per run. A terminal shows the digits at the end of each id, which every command takes, and what fits."""
    width = terminal_width()
    cards = [card for _, card in runs]
    keys = [key for key, value in (cards[0] if cards else {}).items() if not isinstance(value, list | Mapping)]
    columns = [key for key in keys if len({str(card.get(key)) for card in cards}) > 1][:_MOST_COLUMNS]
    medians = [entry.medians for entry, _ in runs]
    results = [name for name in _RESULTS if any(name in each for each in medians)]
    failed = ["outcome"] if any(entry.outcome != "ok" for entry, _ in runs) else []
    rows = [
        [
            *([entry.id] if width is None else [digits(entry.id), entry.name]),
            *(entry.outcome for _ in failed),
            *(_cell(card.get(column), 6) for column in columns),
            *(_cell(values.get(name), 3) for name in results),
            entry.finished[:16].replace("T", " "),
            duration(entry.wall_s),
        ]
        for (entry, card), values in zip(runs, medians, strict=True)
    ]
    names = ["id"] if width is None else ["id", "name"]
    return table(rows, [*names, *failed, *columns, *results, "finished (UTC)", "took"], width)


def _cell(value: object, digits: int) -> object:
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    return "" if value is None else str(value).lower() if isinstance(value, bool) else value
