"""One run as its card shows it: what was chosen, what came out, where it comes from, how to make it again."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from repro.report.content import Content
from repro.report.html.metric_rows import MetricRow, metric_rows
from repro.report.html.references import References, references
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.table_schema import CARD, as_text, plain

NAMED_BY = ("model", "basis", "hidden", "objective", "optimiser", "sequence")
LOOP_COLUMNS = (
    *("member", "controller", "setting", "task", "start", "x_des", "mismatch", "success", "contact"),
    *("clearance_min_m", "held_from_s", "solve_ms_median", "fallbacks"),
)


@dataclass(frozen=True)
class RunPage:
    """One run, whatever experiments list it. A bench has no card columns and shows its comparisons."""

    id: str
    title: str
    experiments: tuple[str, ...]
    outcome: str = "ok"
    error: str = ""
    stale: bool = False
    members: Mapping[int, str] = field(default_factory=dict)
    command: str = ""
    chosen: Mapping[str, str] = field(default_factory=dict)
    metrics: Sequence[MetricRow] = ()
    loops: Sequence[Mapping[str, Any]] = ()
    benches: Sequence[Mapping[str, Any]] = ()
    stages: Sequence[Mapping[str, Any]] = ()
    references: References = field(default_factory=References)


def run_pages(content: Content) -> list[RunPage]:
    """Make the card of every stored run, in the order of the results; a run of several experiments has one."""
    referred = references(content)
    tried = content.results.sensitivity
    cards = _cards(content, content.results, referred)
    known = {card.id for card in cards}
    others = _cards(content, tried.results, referred) if tried is not None else []
    return cards + [card for card in others if card.id not in known]


def _cards(content: Content, results: Results, referred: Mapping[str, References]) -> list[RunPage]:
    tables = _Tables(results)
    listed: dict[str, list[dict[str, Any]]] = {}
    for row in results.runs.to_dict("records"):
        if row["run"]:
            listed.setdefault(row["run"], []).append({str(key): value for key, value in row.items()})
    systems = content.paper.systems
    cards = [_card(id, rows, tables, systems, referred.get(id, References())) for id, rows in listed.items()]
    benches = [id for id in tables.benches if id not in listed]
    return cards + [_bench(id, tables, referred.get(id, References())) for id in benches]


class _Tables:
    """The result tables, split by run once."""

    def __init__(self, results: Results) -> None:
        first = results.metrics.drop_duplicates(["run", "member", "split", "metric"])
        self.metrics = {str(id): rows for id, rows in first.groupby("run", sort=False)}
        self.loops = _records(results.control.drop_duplicates(["run", "member", "controller", "start", "x_des"]))
        self.benches = _records(results.bench)
        self.stages = _records(results.stages)


def _records(table: Any) -> dict[str, list[dict[str, Any]]]:
    by_run: dict[str, list[dict[str, Any]]] = {}
    for row in table.to_dict("records"):
        by_run.setdefault(row["run"], []).append({str(key): plain(value) for key, value in row.items()})
    return by_run


def _card(
    id: str, rows: Sequence[Mapping[str, Any]], tables: _Tables, systems: Mapping[str, str], referred: References
) -> RunPage:
    row = rows[0]
    statuses = list(row["member_status"])
    members = {int(seed): statuses[n] if n < len(statuses) else "ok" for n, seed in enumerate(row["seeds"])}
    texts = {column: as_text(plain(row[column])) for column in CARD}
    return RunPage(
        id=id,
        title=_title(texts, systems),
        experiments=tuple(dict.fromkeys(str(listing["experiment"]) for listing in rows)),
        outcome=str(row["outcome"]),
        error=str(row["error"]),
        stale=plain(row["stale"]) is True,
        members=members,
        command=str(row["command"]),
        chosen={column: text for column, text in texts.items() if text},
        metrics=metric_rows(tables.metrics.get(id), members),
        loops=tables.loops.get(id, []),
        stages=[_stage(stage) for stage in tables.stages.get(id, [])],
        references=referred,
    )


def _bench(id: str, tables: _Tables, referred: References) -> RunPage:
    rows = tables.benches[id]
    command = str(rows[0]["command"] or "")
    return RunPage(id, "Paired timings", ("timing",), command=command, benches=rows, references=referred)


def _title(texts: Mapping[str, str], systems: Mapping[str, str]) -> str:
    parts = (written(column, texts[column]) for column in NAMED_BY if texts[column])
    system = systems.get(texts["system"], texts["system"].replace("_", " "))
    return f"{system}: {', '.join(parts)}"


def _stage(stage: Mapping[str, Any]) -> dict[str, Any]:
    return {**stage, "config": json.loads(stage["config"] or "{}"), "libraries": json.loads(stage["libraries"] or "{}")}
