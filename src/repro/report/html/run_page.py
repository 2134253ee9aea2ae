"""One run as its card shows it: what was chosen, what came out, where it comes from, how to make it again."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from statistics import median

from repro.report.sections import Content
from repro.results.metric_names import metric_named, written
from repro.results.results import Results
from repro.results.run_setting import Metrics
from repro.results.table_schema import CARD, Row, as_text, records

NAMED_BY = ("model", "basis", "hidden", "objective", "optimiser", "sequence")
LOOP_COLUMNS = (
    *("member", "controller", "setting", "task", "start", "x_des", "mismatch", "success", "contact"),
    *("clearance_min_m", "held_from_s", "solve_ms_median", "fallbacks"),
)
ONE_LOOP = ["run", "member", "controller", "start", "x_des"]
SPLITS = {"test": "on the test set", "free": "on the test part of D_H", "train": "of the training"}


# Of a bench, which has no card columns and shows its comparisons.
BENCH: Row = {"title": "Paired timings", "experiments": ("timing",), "outcome": "ok", "error": "", "stale": False}
BENCH |= {"members": {}, "chosen": {}, "metrics": (), "loops": (), "stages": ()}


def run_pages(content: Content) -> list[Row]:
    """Make the card of every stored run, in the order of the results; a run of several experiments has one.

    Beside its row of the runs table it has what it answers (claims by name, tables by name and title), members by seed,
    and metrics, whose `values` hold one per member, nan where it has none.
    """
    claims: dict[str, list[str]] = {}
    for verdict in content.verdicts:
        for run in verdict.runs:
            claims.setdefault(run, []).append(verdict.claim.name)
    tables: dict[str, dict[str, str]] = {}
    for table in content.tables[1:]:
        for run in {run for row in table.rows for run in row.runs}:
            tables.setdefault(run, {})[table.name] = table.title
    pages: dict[str, Row] = {}
    for results in filter(None, (content.results, content.results.sensitivity)):
        for page in _pages(results, content.paper.systems):
            own = {"claims": claims.get(page["id"], ()), "tables": tables.get(page["id"], {})}
            pages.setdefault(page["id"], page | own)
    return [*pages.values()]


def _pages(results: Results, systems: Mapping[str, str]) -> Iterator[Row]:
    loops = _by_run(records(results.control.drop_duplicates(ONE_LOOP)))
    benches, stages = _by_run(records(results.bench)), _by_run(records(results.stages))
    listed = _by_run([row for row in results.rows if row["run"]])
    for id, rows in listed.items():
        row = rows[0]
        statuses = row["member_status"]
        members = {int(seed): statuses[n] if n < len(statuses) else "ok" for n, seed in enumerate(row["seeds"])}
        texts = {column: as_text(row[column]) for column in CARD}
        named = [written(column, texts[column]) for column in NAMED_BY if texts[column]]
        system = systems.get(texts["system"], texts["system"].replace("_", " "))
        yield row | {
            "id": id,
            "title": f"{system}: {', '.join(named)}",
            "experiments": tuple(dict.fromkeys(listing["experiment"] for listing in rows)),
            "members": members,
            "chosen": {column: text for column, text in texts.items() if text},
            "metrics": _metric_rows(results.measured.get(id, {}), members),
            "loops": loops.get(id, ()),
            "benches": (),
            "stages": [
                stage | {name: json.loads(stage[name] or "{}") for name in ("config", "libraries")}
                for stage in stages.get(id, ())
            ],
        }
    for id, rows in benches.items():
        if id not in listed:
            yield BENCH | {"id": id, "command": rows[0]["command"], "benches": rows}


def _by_run(rows: Sequence[Row]) -> dict[str, list[Row]]:
    by_run: dict[str, list[Row]] = {}
    for row in rows:
        by_run.setdefault(row["run"], []).append(row)
    return by_run


def _metric_rows(measured: Metrics, members: Mapping[int, str]) -> list[Row]:
    """The metrics of one run in their stored order, test set first."""
    rows = []
    for (name, split), of in measured.items():
        values = [of.values.get(seed, math.nan) for seed in members]
        finite = [value for value in values if not math.isnan(value)]
        middle = median(finite) if finite else math.nan
        texts = {"label": metric_named(name).label, "meaning": metric_named(name).meaning}
        shown_unit = "" if of.unit == "1" else of.unit
        rows.append({"split": split, "name": name, **texts, "unit": shown_unit, "median": middle, "values": values})
    return sorted(rows, key=lambda row: [*SPLITS].index(row["split"]))
