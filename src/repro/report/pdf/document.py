"""The report's content as plain values for the typesetter, with tables and figures numbered in reading order."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from repro.claims.headline import counts_of_claims
from repro.claims.verdicts import Verdict
from repro.report import writing
from repro.report.content import Content
from repro.report.pdf.numbering import Numbers
from repro.report.pdf.page_table import page_table
from repro.report.pdf.prose import blocks
from repro.report.sections import ReportSection
from repro.report.tables.cost import cost_table
from repro.report.tables.table import Table
from repro.report.tables.verdicts import cure, marks, measured

TEXTS = "texts"  # the folder of the texts outside the sections, each shown by its name
# Shown by the document in a place of their own.
SENSITIVITY, FAILURES = "sensitivity", "failures"
OWN = ("verdicts", SENSITIVITY, FAILURES, "cost")
UNKNOWN_COST = "These results do not say what their stages cost, nor on which machine."
DIGITS = 10  # of a run's id, as many as tell all runs apart


def document(content: Content) -> dict[str, Any]:
    """Return everything that the paper says.

    Raises UserError for a mistake in a text.
    """
    numbers = Numbers()
    claims = _claims(content.verdicts, numbers)
    tables = {table.name: table for table in content.tables}
    wide: list[Table] = []
    sections = [_section(section, content, tables, numbers, wide) for section in content.sections]
    sections += _others(content, tables, numbers, wide)
    costs = cost_table(content.results)
    texts = {Path(name).stem: blocks(content.texts.fill(name)) for name in content.texts.names(TEXTS)}
    body = {
        "title": content.paper.title,
        "subtitle": content.paper.subtitle,
        "made": f"Made from stored results of scale {content.results.scale or 'unknown'}; no number in it is typed.",
        "counts": [*counts_of_claims(content.verdicts).items()],
        "claims": claims,
        "sections": sections,
        "assumptions": [_assumption(row) for row in content.assumptions],
        "trials": _figures((SENSITIVITY,), content, numbers),
        SENSITIVITY: numbers.table(tables[SENSITIVITY]) if SENSITIVITY in tables else None,
        FAILURES: numbers.table(tables[FAILURES]) if FAILURES in tables else None,
        "costs": numbers.table(costs) if costs.rows else None,
        "answers": _answers(content.verdicts, numbers),
        "runs": _runs(content, numbers),
        **texts,
    }
    if not costs.rows:
        body["cost"] = blocks(UNKNOWN_COST)
    appendix = [numbers.table(table) for table in wide]
    places = {entry["name"]: entry["number"] for entry in appendix}
    for section in sections:
        section["appended"] = [places[name] for name in section["appended"]]
    return body | {"appendix": appendix}


def _claims(verdicts: Sequence[Verdict], numbers: Numbers) -> dict[str, Any]:
    rows = [
        {
            "name": verdict.claim.name,
            "about": verdict.claim.about,
            "section": verdict.claim.section,
            "measured": measured(verdict).replace("^2", "²"),
            "printed": writing.number(verdict.claim.printed),
            "ours": {"main": writing.number(verdict.estimate.median), "below": _interval(verdict)},
            "n": str(verdict.estimate.n or writing.ABSENT),
            "verdict": verdict.verdict,
            "remark": _remark(verdict),
        }
        for verdict in verdicts
    ]
    caption = "n: members, starts or problem sizes. In parentheses: where the paper says so."
    return {"number": numbers.next_table(), "caption": caption, "rows": rows}


def _interval(verdict: Verdict) -> str:
    return writing.interval(verdict.estimate).partition(" ")[2]


def _remark(verdict: Verdict) -> str:
    change = cure(verdict)
    parts = [*marks(verdict), verdict.flag, verdict.claim.reason, f"holds with: {change}" if change else ""]
    return "; ".join(part for part in parts if part)


def _section(
    section: ReportSection, content: Content, tables: Mapping[str, Table], numbers: Numbers, wide: list[Table]
) -> dict[str, Any]:
    shown = [page_table(tables[name]) for name in section.tables if name in tables]
    narrow = [entry["name"] for entry in shown if not entry["landscape"]]
    wide += [tables[entry["name"]] for entry in shown if entry["landscape"]]
    known = {verdict.claim.name: verdict.verdict for verdict in content.verdicts}
    return {
        "title": section.title,
        "claims": [{"name": name, "verdict": known[name]} for name in section.claims if name in known],
        "parts": [{"heading": part.heading, "blocks": blocks(part.text)} for part in section.parts],
        "figures": _figures(section.figures, content, numbers),
        "tables": [numbers.table(tables[name]) for name in narrow],
        "appended": [entry["name"] for entry in shown if entry["landscape"]],
    }


def _figures(names: Sequence[str], content: Content, numbers: Numbers) -> list[dict[str, Any]]:
    drawn = {figure.name: figure for figure in content.figures}
    return [
        {
            "path": f"{name}.pdf",
            "number": numbers.next_figure(),
            "title": drawn[name].title,
            "caption": drawn[name].caption,
        }
        for name in names
        if name in drawn
    ]


def _others(content: Content, tables: Mapping[str, Table], numbers: Numbers, wide: list[Table]) -> list[dict[str, Any]]:
    """Return a section of whatever no section names, such as an experiment or a claim that somebody added."""
    shown = {name for section in content.sections for name in section.claims}
    named = {SENSITIVITY, *(name for section in content.sections for name in (*section.tables, *section.figures))}
    figures = tuple(figure.name for figure in content.figures if figure.name not in named)
    left = tuple(name for name in tables if name not in named and name not in OWN)
    claims = tuple(verdict.claim.name for verdict in content.verdicts if verdict.claim.name not in shown)
    if not (figures or left or claims):
        return []
    others = ReportSection("others", "Other experiments", (), figures, left, claims)
    return [_section(others, content, tables, numbers, wide)]


def _assumption(row: Any) -> dict[str, str]:
    names = ("id", "where", "quote", "problem", "choice", "config", "evidence")
    return {name: getattr(row, name).rstrip(".") for name in names}


def _answers(verdicts: Sequence[Verdict], numbers: Numbers) -> dict[str, Any]:
    rows = [
        {
            "name": verdict.claim.name,
            "experiment": verdict.claim.experiment,
            "runs": " ".join(run[-DIGITS:] for run in verdict.runs) or "not run",
        }
        for verdict in verdicts
    ]
    caption = "The last digits of each run's ID; an experiment as a whole: repro run -m experiment=NAME scale=paper."
    return {"number": numbers.next_table(), "caption": caption, "rows": rows}


def _runs(content: Content, numbers: Numbers) -> dict[str, Any]:
    runs = content.results.runs.drop_duplicates("run")
    rows = [
        {"run": run["run"][-DIGITS:], "command": run["command"]}
        for run in runs[runs["outcome"] == "ok"].sort_values(["experiment", "run"]).to_dict("records")
    ]
    return {"number": numbers.next_table(), "caption": "In the order of the experiments.", "rows": rows}
