"""The whole folder of pages: front page, claims, run cards, and what they share."""

import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from repro.claims.headline import headline
from repro.claims.verdicts import VERDICTS, Verdict
from repro.report.content import Content
from repro.report.figures.figure import Figure
from repro.report.html.animations import copy_animations
from repro.report.html.environment import ASSETS, rendered
from repro.report.html.metric_rows import SPLITS
from repro.report.html.rule import rule
from repro.report.html.run_page import LOOP_COLUMNS, run_pages
from repro.report.sections import ReportSection
from repro.report.summary import finished_runs
from repro.report.tables.table import Table
from repro.report.tables.verdicts import READING, cure, mark, measured
from repro.results.results import SENSITIVITY
from repro.tracking.files import write_text

CLAIMS, RUNS = "claims", "runs"


def write_site(content: Content, folder: Path, paper: Path) -> None:
    """Write index.html, claims/ID.html, runs/ID.html and assets under a report's folder, which holds figures/, tables/.

    `paper` is the checkout's paper folder, whose animations are copied.
    """
    shutil.copytree(ASSETS, folder / "assets", dirs_exist_ok=True, copy_function=shutil.copyfile)
    cards = run_pages(content)
    claims = {verdict.claim.name: verdict for verdict in content.verdicts}
    shared = {
        "paper": content.paper,
        "scale": content.results.scale or "unknown",
        "claims": claims,
        "known_runs": {card.id for card in cards},
        "mark": mark,
        "measured": measured,
        "ratio": _ratio,
    }
    front = _front(content) | {
        "animations": copy_animations(content.paper.animations, paper / "animations", folder / "animations"),
        "finished": finished_runs(content.results),
        "pdf": (folder / "report.pdf").is_file(),
        "cards": cards,
    }
    pages = {Path("index.html"): rendered("index.html", base="", **shared, **front)}
    names = list(claims)
    for place, name in enumerate(names):
        beside = {"before": names[place - 1] if place else "", "after": "".join(names[place + 1 : place + 2])}
        pages[Path(CLAIMS) / f"{name}.html"] = rendered(
            "claim.html", base="../", verdict=claims[name], rule=rule(claims[name]), **beside, **shared
        )
    for card in cards:
        pages[Path(RUNS) / f"{card.id}.html"] = rendered(
            "run.html", base="../", card=card, splits=SPLITS, loop_columns=LOOP_COLUMNS, **shared
        )
    _write(folder, pages)


def _front(content: Content) -> dict[str, Any]:
    counted = Counter(verdict.verdict for verdict in content.verdicts)
    used_figures = {
        SENSITIVITY,
        *content.paper.front_figures,
        *(name for section in content.sections for name in section.figures),
    }
    used_tables = {SENSITIVITY, *(name for section in content.sections for name in section.tables)}
    figures = {figure.name: figure for figure in content.figures}
    tables = {table.name: table for table in content.tables[1:]}
    return {
        "counts": {name: counted[name] for name in VERDICTS if counted[name]},
        "headline": headline(content.verdicts),
        "cure": cure,
        "reading": READING,
        "front_figures": [figures[name] for name in content.paper.front_figures if name in figures],
        "sections": [_section(section, figures, tables) for section in content.sections],
        "other_figures": [figure for name, figure in figures.items() if name not in used_figures],
        "other_tables": [table for name, table in tables.items() if name not in used_tables],
        "assumptions": content.assumptions,
        "sensitivity": tables.get(SENSITIVITY),
        "sensitivity_figure": figures.get(SENSITIVITY),
        "trials": _trials(tables.get(SENSITIVITY)),
    }


def _trials(sensitivity: Table | None) -> Mapping[str, Sequence[Mapping[str, Any]]]:
    """Return what was put in an assumption's place and what that moved, by assumption."""
    trials: dict[str, list[Mapping[str, Any]]] = {}
    for row in sensitivity.rows if sensitivity else ():
        if "alternative" in row.data:
            trials.setdefault(row.data["assumption"], []).append(row.data)
    return trials


def _section(section: ReportSection, figures: Mapping[str, Figure], tables: Mapping[str, Table]) -> dict[str, Any]:
    return {
        "id": section.id,
        "title": section.title,
        "parts": section.parts,
        "figures": [figures[name] for name in section.figures if name in figures],
        "tables": [tables[name] for name in section.tables if name in tables],
        "claims": section.claims,
    }


def _ratio(verdict: Verdict) -> float | None:
    """Return ours over the printed value; None where either is missing."""
    printed = verdict.claim.printed
    return verdict.estimate.median / printed if printed and verdict.estimate.n else None


def _write(folder: Path, pages: Mapping[Path, str]) -> None:
    """Write the pages and remove those of an earlier report that are none of this one."""
    for name, text in pages.items():
        write_text(folder / name, text)
    for kind in (CLAIMS, RUNS):
        for path in (folder / kind).glob("*.html"):
            if path.relative_to(folder) not in pages:
                path.unlink()
