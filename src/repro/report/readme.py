"""The tables in README.md and docs: generated between marks from the committed results."""

import re
from collections.abc import Sequence
from pathlib import Path

from repro.claims.verdicts import Verdict, headline
from repro.errors import UserError
from repro.report.paper import load_paper, paper_folder
from repro.report.tables.models import front_block
from repro.report.tables.table import markdown_table
from repro.report.tables.verdicts import in_words, titles
from repro.results.results import Results
from repro.tracking.files import write_text

PAGES = {"count": "README.md", "headlines": "README.md", "verdicts": "docs/verdicts.md"}
# Of what `in_words` writes.
SHORT = ("claim", "about", "printed", "compared", "marked")
LONG = ("claim", "section", "about", "measured", "printed", "compared", "members", "flagged", "cure")


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
        "headlines": _table(SHORT, [by_name[name] for name in paper.headlines]),
        "verdicts": _table(LONG, verdicts),
        **{table.name: front_block(results, table) for table in paper.front_tables},
    }


def page_of(root: Path, name: str) -> Path:
    """Return the page of a checkout that shows the table of this name."""
    return root / PAGES.get(name, "docs/better-models.md")


def parts(page: Path, name: str) -> tuple[str, str, str]:
    """Return the text of a page before, within and after the marks of a table. Raises UserError where it lacks them."""
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    match = re.fullmatch(rf"(.*?{begin})(.*?)({end}.*)", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    if match is None:
        raise UserError(f"{page} lacks the marks {begin} and {end}; the table of {name} goes between them")
    return match[1], match[2], match[3]


def _table(names: Sequence[str], verdicts: Sequence[Verdict]) -> str:
    shown = map(in_words, verdicts)
    return markdown_table(titles(names), [[words[name] for name in names] for words in shown])
