"""The tables in README.md and docs: generated between marks, and checked against the committed results."""

import re
from collections.abc import Sequence
from pathlib import Path

from repro.claims.assumption_effects import assumption_effects
from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.verdicts import Verdict, headline, judge_all
from repro.errors import UserError
from repro.report import writing
from repro.report.paper import load_paper, paper_folder
from repro.report.tables.drift import table_drift
from repro.report.tables.front import front_block
from repro.report.tables.sensitivity import sensitivity_table
from repro.report.tables.table import Table, markdown_head, markdown_line
from repro.report.tables.verdicts import cure, mark, measured, verdict_table
from repro.results.results import Results
from repro.tracking.files import write_text

PAGES = {"count": "README.md", "headlines": "README.md", "verdicts": "docs/verdicts.md"}
SHORT = ("claim", "what the paper says", "printed", "ours [95 %]", "verdict")
TITLES = ("claim", "what the paper says", "measured", "printed", "ours [95 %]", "units", "verdict", "smallest change")


def verdict_block(verdicts: Sequence[Verdict]) -> str:
    """Return one line per claim or part of one."""
    lines = markdown_head(TITLES)
    for verdict in verdicts:
        name, about, printed, ours, judged = _judged(verdict)
        units = str(verdict.estimate.n or writing.ABSENT)
        flagged = f"{judged}; {verdict.flag}" if verdict.flag else judged
        lines.append(_line(name, about, measured(verdict), printed, ours, units, flagged, cure(verdict)))
    return "\n".join(lines)


def headline_block(verdicts: Sequence[Verdict], names: Sequence[str]) -> str:
    """Return one short line for each of the claims of these names. Raises UserError for a name that is no claim."""
    by_name = {verdict.claim.name: verdict for verdict in verdicts}
    if unknown := [name for name in names if name not in by_name]:
        raise UserError(f"report.yaml, headlines: no claim is called {', '.join(unknown)}")
    return "\n".join([*markdown_head(SHORT), *(_line(*_judged(by_name[name])) for name in names)])


def _judged(verdict: Verdict) -> tuple[str, str, str, str, str]:
    claim = verdict.claim
    ours = writing.interval(verdict.estimate)
    ours += f" against {writing.interval(verdict.other)}" if verdict.other else ""
    return claim.name, claim.about, writing.number(claim.printed), ours, mark(verdict)


def _line(*cells: str) -> str:
    return markdown_line([writing.markdown(cell) for cell in cells])


def write_tables(root: Path, results: Results, verdicts: Sequence[Verdict]) -> None:
    """Replace the text between the marks of each table in a checkout. Raises UserError where a page lacks them."""
    for name, block in _blocks(results, verdicts).items():
        before, _, after = _parts(_page(root, name), name)
        write_text(_page(root, name), f"{before}\n{block}\n{after}")


def drift(root: Path) -> list[str]:
    """List where README.md, docs and the verdicts of paper/results differ from what its results give; [] when nowhere.

    `root` is the checkout: it holds README.md, docs, paper/claims.yaml, paper/assumptions.yaml and paper/results.
    """
    paper = root / "paper"
    results, claims = Results.load(paper / "results"), load_claims(paper / "claims.yaml")
    verdicts = judge_all(claims, results)
    differences = []
    for name, block in _blocks(results, verdicts).items():
        page = _page(root, name)
        if _parts(page, name)[1].strip() != block.strip():
            shown = page.relative_to(root).as_posix()
            differences.append(f"{shown} shows another table of {name} than paper/results gives")
    computed: dict[str, tuple[Table, Sequence[str]]] = {"claims.csv": (verdict_table(verdicts), ("id",))}
    if results.sensitivity is not None:
        ledger = load_assumptions(paper / "assumptions.yaml")
        table = sensitivity_table(ledger, assumption_effects(results.sensitivity, claims))
        computed["sensitivity.csv"] = (table, ("assumption", "alternative", "claim"))
    for name, (table, key) in computed.items():
        differences += table_drift(paper / "results" / name, table, key)
    return differences


def _blocks(results: Results, verdicts: Sequence[Verdict]) -> dict[str, str]:
    paper = load_paper(paper_folder())
    tables = {table.name: front_block(results, table) for table in paper.front_tables}
    shown = {"count": f"**{headline(verdicts)}.**", "headlines": headline_block(verdicts, paper.headlines)}
    return shown | {"verdicts": verdict_block(verdicts)} | tables


def _page(root: Path, name: str) -> Path:
    return root / PAGES.get(name, "docs/better-models.md")


def _parts(page: Path, name: str) -> tuple[str, str, str]:
    """The text of a page up to the table of this name, the table, and the rest; the marks belong to neither table."""
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    match = re.fullmatch(rf"(.*?{begin})(.*?)({end}.*)", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    if match is None:
        message = f"{page} lacks the marks {begin} and {end}; the table of {name} goes between them"
        raise UserError(message)
    return match[1], match[2], match[3]
