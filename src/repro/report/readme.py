"""The tables in README.md: generated between marks, and checked against the committed results."""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from repro.errors import UserError
from repro.report import writing
from repro.report.claims import load_claims
from repro.report.files import write_text
from repro.report.front_table import FRONT_TABLES, front_block
from repro.report.results import Results
from repro.report.verdict_table import mark, measured
from repro.report.verdicts import VERDICTS, Verdict, judge_all

BLOCKS = ("verdicts", *FRONT_TABLES)


def verdict_block(verdicts: Sequence[Verdict]) -> str:
    """Return what stands between the marks: the count of verdicts, then one line a claim."""
    counted = Counter(verdict.verdict for verdict in verdicts)
    counts = ", ".join(f"{counted[name]} {name}" for name in VERDICTS if counted[name])
    lines = [
        f"{len(verdicts)} claims and parts of claims: {counts}.",
        "",
        "| claim | what the paper says | measured | printed | ours [95 %] | members | verdict |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
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
        )
        lines.append(f"| {' | '.join(writing.markdown(cell) for cell in cells)} |")
    return "\n".join(lines)


def write_tables(readme: Path, results: Results, verdicts: Sequence[Verdict]) -> None:
    """Replace the text between the marks of each table. Raises UserError where README.md lacks them."""
    for name, block in _blocks(results, verdicts).items():
        before, _, after = _parts(readme, name)
        write_text(readme, f"{before}{_begin(name)}\n{block}\n{_end(name)}{after}")


def drift(root: Path) -> list[str]:
    """Say where README.md and paper/results/claims.csv differ from what the committed results give; [] when nowhere.

    `root` is the checkout: it holds README.md, paper/claims.yaml and paper/results.
    """
    results = Results.load(root / "paper" / "results")
    verdicts = judge_all(load_claims(root / "paper" / "claims.yaml"), results)
    found = []
    for name, block in _blocks(results, verdicts).items():
        _, stands, _ = _parts(root / "README.md", name)
        if stands.strip() != block.strip():
            found.append(f"README.md shows another table of {name} than paper/results gives")
    path = root / "paper" / "results" / "claims.csv"
    with path.open(encoding="utf-8", newline="") as stream:
        committed = {row["id"]: row["verdict"] for row in csv.DictReader(stream)}
    for verdict in verdicts:
        name, now = verdict.claim.name, verdict.verdict
        if committed.pop(name, None) != now:
            found.append(f"{path.name} holds another verdict on {name} than {now}")
    return [*found, *(f"{path.name} holds {name}, which is no claim" for name in committed)]


def _blocks(results: Results, verdicts: Sequence[Verdict]) -> dict[str, str]:
    tables = {name: front_block(results, table) for name, table in FRONT_TABLES.items()}
    return {"verdicts": verdict_block(verdicts)} | tables


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
