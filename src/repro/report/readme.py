"""The tables in README.md: generated between marks, and checked against the committed results."""

import re
from collections.abc import Sequence
from pathlib import Path

from repro.claims.assumption_effects import assumption_effects
from repro.claims.assumptions import load_assumptions
from repro.claims.claims import load_claims
from repro.claims.headline import headline
from repro.claims.verdicts import Verdict, judge_all
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

TITLES = ("claim", "what the paper says", "measured", "printed", "ours [95 %]", "units", "verdict", "smallest change")


def count_block(verdicts: Sequence[Verdict]) -> str:
    """Return the count of claims by class in one line."""
    return f"**{headline(verdicts)}.**"


def verdict_block(verdicts: Sequence[Verdict]) -> str:
    """Return one line per claim or part of one."""
    lines = markdown_head(TITLES)
    for verdict in verdicts:
        claim = verdict.claim
        cells = (
            claim.name,
            claim.about,
            measured(verdict),
            writing.number(claim.printed),
            writing.interval(verdict.estimate),
            str(verdict.estimate.n or writing.ABSENT),
            f"{mark(verdict)}; {verdict.flag}" if verdict.flag else mark(verdict),
            cure(verdict),
        )
        lines.append(markdown_line([writing.markdown(cell) for cell in cells]))
    return "\n".join(lines)


def write_tables(readme: Path, results: Results, verdicts: Sequence[Verdict]) -> None:
    """Replace the text between the marks of each table. Raises UserError where README.md lacks them."""
    for name, block in _blocks(results, verdicts).items():
        before, _, after = _parts(readme, name)
        write_text(readme, f"{before}{_begin(name)}\n{block}\n{_end(name)}{after}")


def drift(root: Path) -> list[str]:
    """List where README.md and the verdicts in paper/results differ from what the results there give; [] when nowhere.

    `root` is the checkout: it holds README.md, paper/claims.yaml, paper/assumptions.yaml and paper/results.
    """
    paper = root / "paper"
    results, claims = Results.load(paper / "results"), load_claims(paper / "claims.yaml")
    verdicts = judge_all(claims, results)
    differences = []
    for name, block in _blocks(results, verdicts).items():
        _, stands, _ = _parts(root / "README.md", name)
        if stands.strip() != block.strip():
            differences.append(f"README.md shows another table of {name} than paper/results gives")
    computed: dict[str, tuple[Table, Sequence[str]]] = {"claims.csv": (verdict_table(verdicts), ("id",))}
    if results.sensitivity is not None:
        ledger = load_assumptions(paper / "assumptions.yaml")
        table = sensitivity_table(ledger, assumption_effects(results.sensitivity, claims))
        computed["sensitivity.csv"] = (table, ("assumption", "alternative", "claim"))
    for name, (table, key) in computed.items():
        differences += table_drift(paper / "results" / name, table, key)
    return differences


def _blocks(results: Results, verdicts: Sequence[Verdict]) -> dict[str, str]:
    tables = {table.name: front_block(results, table) for table in load_paper(paper_folder()).front_tables}
    return {"count": count_block(verdicts), "verdicts": verdict_block(verdicts)} | tables


def _begin(name: str) -> str:
    return f"<!-- {name}:begin -->"


def _end(name: str) -> str:
    return f"<!-- {name}:end -->"


def _parts(readme: Path, name: str) -> tuple[str, str, str]:
    text = readme.read_text(encoding="utf-8")
    begin, end = _begin(name), _end(name)
    match = re.fullmatch(rf"(.*?){re.escape(begin)}(.*?){re.escape(end)}(.*)", text, flags=re.DOTALL)
    if match is None:
        message = f"{readme} lacks the marks {begin} and {end}; the table of {name} goes between them"
        raise UserError(message)
    return match[1], match[2], match[3]
