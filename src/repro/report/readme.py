"""The tables in README.md and docs: generated between marks from the committed results."""

import re
from collections.abc import Sequence
from pathlib import Path

from repro.claims.verdicts import Verdict, headline
from repro.errors import UserError
from repro.report import writing
from repro.report.paper import load_paper, paper_folder
from repro.report.tables.front import front_block
from repro.report.tables.table import markdown_table
from repro.report.tables.verdicts import cure, mark, measured
from repro.results.results import Results
from repro.tracking.files import write_text

PAGES = {"count": "README.md", "headlines": "README.md", "verdicts": "docs/verdicts.md"}
SHORT = ("claim", "what the paper says", "printed", "ours [95 %]", "verdict")
TITLES = (
    *("claim", "where", "what the paper says", "measured", "printed"),
    *("ours [95 %]", "units", "verdict", "smallest change"),
)


def write_tables(root: Path, results: Results, verdicts: Sequence[Verdict]) -> None:
    """Replace the text between the marks of each table in a checkout. Raises UserError where a page lacks them."""
    for name, block in blocks(results, verdicts).items():
        before, _, after = parts(page_of(root, name), name)
        write_text(page_of(root, name), f"{before}\n{block}\n{after}")


def blocks(results: Results, verdicts: Sequence[Verdict]) -> dict[str, str]:
    """Return name -> table in Markdown. Raises UserError for a headline that is no claim."""
    paper, by_name = load_paper(paper_folder()), {verdict.claim.name: verdict for verdict in verdicts}
    if unknown := [name for name in paper.headlines if name not in by_name]:
        raise UserError(f"report.yaml, headlines: no claim is called {', '.join(unknown)}")
    return {
        "count": f"**{headline(verdicts)}.**",
        "headlines": markdown_table(SHORT, [_short(by_name[name]) for name in paper.headlines]),
        "verdicts": markdown_table(TITLES, map(_long, verdicts)),
        **{table.name: front_block(results, table) for table in paper.front_tables},
    }


def page_of(root: Path, name: str) -> Path:
    """Return the page of a checkout that shows the table of this name."""
    return root / PAGES.get(name, "docs/better-models.md")


def parts(page: Path, name: str) -> tuple[str, str, str]:
    """Return the text of a page up to the table of this name, the table, and the rest; the marks belong to neither.

    Raises UserError where the page lacks the marks.
    """
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    match = re.fullmatch(rf"(.*?{begin})(.*?)({end}.*)", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    if match is None:
        raise UserError(f"{page} lacks the marks {begin} and {end}; the table of {name} goes between them")
    return match[1], match[2], match[3]


def _short(verdict: Verdict) -> tuple[str, str, str, str, str]:
    claim = verdict.claim
    ours = writing.interval(verdict.estimate)
    ours += f" against {writing.interval(verdict.other)}" if verdict.other else ""
    return claim.name, claim.about, writing.number(claim.printed), ours, mark(verdict)


def _long(verdict: Verdict) -> tuple[str, ...]:
    name, about, printed, ours, judged = _short(verdict)
    flagged = f"{judged}; {verdict.flag}" if verdict.flag else judged
    units = str(verdict.estimate.n or writing.ABSENT)
    return name, verdict.claim.section, about, measured(verdict), printed, ours, units, flagged, cure(verdict)
