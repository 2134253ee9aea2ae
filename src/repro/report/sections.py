"""The sections of the report: ordered texts under paper/report/sections, in which every number is a placeholder.

Both the page and the PDF are made from them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from repro.claims.verdicts import Verdict
from repro.errors import UserError
from repro.report.placeholders import fill
from repro.results.results import Results

HEADINGS = ("Asked", "Done", "Found", "Against expectation")
LISTS = ("figures", "tables", "claims")


@dataclass(frozen=True)
class Part:
    """What stands under one heading of a section; `text` is Markdown: paragraphs, lists, emphasis, code."""

    heading: str
    text: str


@dataclass(frozen=True)
class Section:
    """One section: its texts, and the figures, tables and claims (by name) that it shows."""

    id: str
    title: str
    parts: tuple[Part, ...]
    figures: tuple[str, ...]
    tables: tuple[str, ...]
    claims: tuple[str, ...]


def filled_sections(folder: Path, results: Results, verdicts: Sequence[Verdict]) -> list[Section]:
    """Load the sections and fill their placeholders; a part of which nothing is left falls out.

    Raises UserError for a mistake in a text; a result that is missing reads "not run".
    """
    filled = []
    for section in load_sections(folder):
        place = f"section {section.id}"
        parts = [replace(part, text=fill(part.text, results, verdicts, place)) for part in section.parts]
        filled.append(replace(section, parts=tuple(part for part in parts if part.text)))
    return filled


def load_sections(folder: Path) -> list[Section]:
    """Read the sections in the order of their file names. Raises UserError naming the file and the fault."""
    paths = sorted(folder.glob("*.md"))
    if not paths:
        message = f"{folder} holds no sections of the report (*.md)"
        raise UserError(message)
    return [_section(path) for path in paths]


def _section(path: Path) -> Section:
    import yaml

    _, mark, rest = path.read_text(encoding="utf-8").partition("---\n")
    head, end, body = rest.partition("\n---\n")
    try:
        facts = yaml.safe_load(head) if mark and end else None
    except yaml.YAMLError as error:
        message = f"{path}: the lines between --- are no YAML: {error}"
        raise UserError(message) from error
    if not isinstance(facts, dict) or set(facts) != {"title", *LISTS}:
        message = f"{path} must begin with title, {', '.join(LISTS)} between two lines of ---"
        raise UserError(message)
    return Section(
        id=path.stem.partition("-")[2],
        title=str(facts["title"]),
        parts=_parts(path, body),
        **{name: tuple(str(entry) for entry in facts[name]) for name in LISTS},
    )


def _parts(path: Path, body: str) -> tuple[Part, ...]:
    before, *blocks = f"\n{body}".split("\n## ")
    parts = [Part(heading.strip(), text.strip()) for heading, _, text in (block.partition("\n") for block in blocks)]
    unknown = [part.heading for part in parts if part.heading not in HEADINGS]
    if before.strip() or unknown or not parts:
        fault = f"{', '.join(unknown)} is no heading" if unknown else "text must stand under a heading"
        message = f"{path}: {fault}; allowed: {', '.join(HEADINGS)}"
        raise UserError(message)
    return tuple(parts)
