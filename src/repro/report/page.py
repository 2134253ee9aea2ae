"""The report as one HTML page that opens from disk: verdicts, figures, tables, assumptions, replay commands."""

import base64
import re
from collections import Counter
from collections.abc import Sequence
from html import escape
from pathlib import Path

from repro.report.assumptions import Assumption
from repro.report.figures.figure import Figure
from repro.report.page_style import CSS
from repro.report.table import Row, Table
from repro.report.verdicts import VERDICTS, Verdict


def page(
    scale: str,
    verdicts: Sequence[Verdict],
    tables: Sequence[Table],
    figures: Sequence[Figure],
    drawn: Path,
    assumptions: Sequence[Assumption],
) -> str:
    """Compose the page; `drawn` is the folder that holds the figures' PNG files, which are embedded."""
    verdict_table, *others = tables
    sections = {
        "verdicts": ("Verdicts", _counts(verdicts) + _table(verdict_table, verdicts)),
        "figures": ("Figures", "".join(_figure(figure, drawn) for figure in figures)),
        "tables": ("Tables", "".join(f"<h3>{escape(t.title)}</h3>{_table(t)}" for t in others)),
        "assumptions": ("Assumptions", _assumptions(assumptions)),
    }
    links = " ".join(f'<a href="#{name}">{title}</a>' for name, (title, _) in sections.items())
    body = "".join(
        f'<section id="{name}"><h2>{title}</h2>{content}</section>' for name, (title, content) in sections.items()
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>Verdicts, scale {escape(scale)}</title>\n<style>{CSS}</style>\n</head>\n<body>\n"
        "<header><h1>Physics-guided and energy-based learning of interconnected systems</h1>"
        f"<p>The paper's claims, asked again of stored runs. Scale: <b>{escape(scale or 'unknown')}</b>.</p>"
        f"<nav>{links}</nav></header>\n<main>{body}</main>\n</body>\n</html>\n"
    )


def _counts(verdicts: Sequence[Verdict]) -> str:
    counted = Counter(verdict.verdict for verdict in verdicts)
    chips = (f'<li class="{_slug(name)}"><b>{counted[name]}</b> {name}</li>' for name in VERDICTS if counted[name])
    return f'<ul class="counts">{"".join(chips)}</ul>'


def _table(table: Table, verdicts: Sequence[Verdict] = ()) -> str:
    head = "".join(f'<th scope="col">{escape(column.title)}</th>' for column in table.columns)
    marks = [_slug(verdict.verdict) for verdict in verdicts] or [""] * len(table.rows)
    rows = "".join(_row(row, mark) for row, mark in zip(table.rows, marks, strict=True))
    return (
        f"<p>{escape(table.caption)}</p>"
        f'<div class="wide" tabindex="0" role="region" aria-label="{escape(table.title)}"><table>'
        f'<thead><tr>{head}<th scope="col">replay</th></tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _row(row: Row, mark: str) -> str:
    kind = " ".join(part for part in (mark, "anchor" if row.anchor else "") if part)
    first, *others = row.cells
    cells = f'<th scope="row">{escape(first)}</th>' + "".join(f"<td>{_cell(cell)}</td>" for cell in others)
    return f'<tr class="{kind}">{cells}<td>{_replay(row)}</td></tr>'


def _cell(text: str) -> str:
    # An interval is secondary to its median and goes below it.
    parts = re.fullmatch(r"(\S+) (\[[^\]]*\])", text)
    return f"{escape(parts[1])}<small>{escape(parts[2])}</small>" if parts else escape(text)


def _replay(row: Row) -> str:
    if not row.runs and not row.commands:
        return ""
    commands = "".join(f"<code>{escape(command)}</code>" for command in row.commands)
    runs = "".join(f"<li>{escape(run)}</li>" for run in row.runs)
    return f"<details><summary>show</summary>{commands}<ul>{runs}</ul></details>"


def _figure(figure: Figure, drawn: Path) -> str:
    image = base64.b64encode((drawn / f"{figure.name}.png").read_bytes()).decode()
    return (
        f'<figure><img alt="{escape(figure.title)}" src="data:image/png;base64,{image}">'
        f"<figcaption><b>{escape(figure.title)}.</b> {escape(figure.caption)}</figcaption></figure>"
    )


def _assumptions(assumptions: Sequence[Assumption]) -> str:
    rows = "".join(
        f'<tr><th scope="row">{escape(a.id)}</th><td>{escape(a.where)}: “{escape(a.quote)}”</td>'
        f"<td>{escape(a.problem)}</td><td>{escape(a.choice)}</td><td><code>{escape(a.config)}</code></td>"
        f"<td>{escape(a.evidence)}</td></tr>"
        for a in assumptions
    )
    titles = ("assumption", "printed", "problem", "our choice", "setting", "evidence")
    head = "".join(f'<th scope="col">{title}</th>' for title in titles)
    return (
        '<div class="wide" tabindex="0" role="region" aria-label="Assumptions"><table class="prose">'
        f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
    )


def _slug(verdict: str) -> str:
    return verdict.replace(" ", "-")
