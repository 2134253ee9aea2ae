"""One run as its card shows it: what was chosen, what came out, where it comes from, how to make it again."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class RunPage:
    """One run, whatever experiments list it, and what it answers: claims by name, tables by name and title.

    A bench has no card columns and shows its comparisons. Of a metric, `values` holds one per member, in the order of
    seeds, nan where it has none.
    """

    id: str
    title: str
    experiments: tuple[str, ...]
    claims: Sequence[str]
    tables: Mapping[str, str]
    outcome: str = "ok"
    error: str = ""
    stale: bool = False
    members: Mapping[int, str] = field(default_factory=dict)
    command: str = ""
    chosen: Mapping[str, str] = field(default_factory=dict)
    metrics: Sequence[Row] = ()
    loops: Sequence[Row] = ()
    benches: Sequence[Row] = ()
    stages: Sequence[Row] = ()


def run_pages(content: Content) -> list[RunPage]:
    """Make the card of every stored run, in the order of the results; a run of several experiments has one."""
    claims: dict[str, list[str]] = {}
    for verdict in content.verdicts:
        for run in verdict.runs:
            claims.setdefault(run, []).append(verdict.claim.name)
    tables: dict[str, dict[str, str]] = {}
    for table in content.tables[1:]:
        for run in {run for row in table.rows for run in row.runs}:
            tables.setdefault(run, {})[table.name] = table.title
    pages: dict[str, RunPage] = {}
    for results in filter(None, (content.results, content.results.sensitivity)):
        for page in _pages(results, content.paper.systems, claims, tables):
            pages.setdefault(page.id, page)
    return [*pages.values()]


def _pages(
    results: Results,
    systems: Mapping[str, str],
    claims: Mapping[str, Sequence[str]],
    tables: Mapping[str, Mapping[str, str]],
) -> Iterator[RunPage]:
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
        yield RunPage(
            id=id,
            title=f"{system}: {', '.join(named)}",
            experiments=tuple(dict.fromkeys(listing["experiment"] for listing in rows)),
            claims=claims.get(id, ()),
            tables=tables.get(id, {}),
            outcome=row["outcome"],
            error=row["error"],
            stale=row["stale"] is True,
            members=members,
            command=row["command"],
            chosen={column: text for column, text in texts.items() if text},
            metrics=_metric_rows(results.measured.get(id, {}), members),
            loops=loops.get(id, ()),
            stages=[
                {**stage, **{name: json.loads(stage[name] or "{}") for name in ("config", "libraries")}}
                for stage in stages.get(id, ())
            ],
        )
    for id, rows in benches.items():
        if id not in listed:
            own = claims.get(id, ()), tables.get(id, {})
            yield RunPage(id, "Paired timings", ("timing",), *own, command=rows[0]["command"], benches=rows)


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
