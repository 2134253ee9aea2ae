"""The sections of the report, of the page and of the PDF: ordered texts in which every number is a placeholder."""

from collections.abc import Sequence
from dataclasses import dataclass

from repro.claims.assumption_effects import AssumptionEffect
from repro.claims.assumptions import Assumption
from repro.claims.verdicts import Verdict
from repro.errors import UserError
from repro.report.figures.figure import Figure
from repro.report.paper import Paper
from repro.report.placeholders import Texts
from repro.report.tables.table import Table
from repro.results.results import Results

FOLDER = "sections"
HEADINGS = ("Question", "Method", "Result", "Discussion")
LISTS = ("figures", "tables", "claims")


@dataclass(frozen=True)
class Part:
    """What stands under one heading of a section; `text` is Markdown: paragraphs, lists, emphasis, code."""

    heading: str
    text: str


@dataclass(frozen=True)
class ReportSection:
    """One section: its texts, and the figures, tables and claims (by name) that it shows."""

    id: str
    title: str
    parts: tuple[Part, ...]
    figures: tuple[str, ...]
    tables: tuple[str, ...]
    claims: tuple[str, ...]


@dataclass(frozen=True)
class Content:
    """Everything that a report shows, before it takes a form; the first of the tables is that of the verdicts."""

    paper: Paper
    results: Results
    verdicts: Sequence[Verdict]
    effects: Sequence[AssumptionEffect]
    tables: Sequence[Table]
    figures: Sequence[Figure]
    assumptions: Sequence[Assumption]
    sections: Sequence[ReportSection]
    texts: Texts


def load_sections(texts: Texts) -> list[ReportSection]:
    """Fill the sections in the order of their file names; a part or a section of which nothing is left falls out.

    A paper without texts has none; a missing result reads "not run". Raises UserError naming the file of a mistake.
    """
    if not texts.folder.is_dir():
        return []
    names = texts.names(FOLDER)
    if not names:
        raise UserError(f"{texts.folder / FOLDER} holds no sections of the report (*.md)")
    sections = (_section(name, texts.fill(name)) for name in names)
    return [section for section in sections if section.parts]


def _section(name: str, text: str) -> ReportSection:
    import yaml

    _, mark, rest = f"{text}\n".partition("---\n")
    head, end, body = rest.partition("\n---\n")
    try:
        facts = yaml.safe_load(head) if mark and end else None
    except yaml.YAMLError as error:
        raise UserError(f"{name}: the lines between --- are no YAML: {error}") from error
    if not isinstance(facts, dict) or set(facts) != {"title", *LISTS}:
        raise UserError(f"{name} must begin with title, {', '.join(LISTS)} between two lines of ---")
    return ReportSection(
        id=name.removesuffix(".md").partition("-")[2],
        title=str(facts["title"]),
        parts=_parts(name, body),
        **{key: tuple(str(entry) for entry in facts[key]) for key in LISTS},
    )


def _parts(name: str, body: str) -> tuple[Part, ...]:
    before, *blocks = f"\n{body}".split("\n## ")
    parts = [Part(heading.strip(), text.strip()) for heading, _, text in (block.partition("\n") for block in blocks)]
    unknown = [part.heading for part in parts if part.heading not in HEADINGS]
    if before.strip() or unknown or not parts:
        fault = f"{', '.join(unknown)} is no heading" if unknown else "text must stand under a heading"
        raise UserError(f"{name}: {fault}; allowed: {', '.join(HEADINGS)}")
    return tuple(part for part in parts if part.text)
