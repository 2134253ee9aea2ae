"""The report as a PDF by typst: texts, claims and figures, without tables; the same content gives the same bytes."""

import json
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from repro.claims.verdicts import counts_of_claims
from repro.report.pdf.prose import blocks
from repro.report.sections import Content
from repro.report.tables.verdicts import in_words
from repro.results.results import SENSITIVITY
from repro.tracking.files import write_bytes

ENTRY = "report.typ"
TEXTS = "texts"  # the folder of the texts outside the sections, each shown by its name
FIGURES = 1  # shown of a section; the others are in the supplement


def write_pdf(content: Content, figures: Path, target: Path) -> None:
    """Typeset the content with the template beside its texts and write the PDF atomically; without texts there is none.

    `figures` holds the drawn figures as PDF files. Raises UserError for a mistake in a text.
    """
    source = content.texts.folder
    if source.is_dir():
        write_bytes(target, typeset(document(content), figures, source))


def typeset(body: Mapping[str, Any], figures: Path, source: Path) -> bytes:
    """Return the PDF of a document. Nothing outside of the two folders and the bundled fonts is read."""
    import typst

    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for path in (*source.glob("*.typ"), *source.glob("*.yaml"), *figures.glob("*.pdf")):
            shutil.copyfile(path, place / path.name)
        (place / "content.json").write_text(json.dumps(body, ensure_ascii=False), encoding="utf-8")
        return typst.compile(place / ENTRY, root=place, ignore_system_fonts=True)


def document(content: Content) -> dict[str, Any]:
    """Return everything that the paper says. Raises UserError for a mistake in a text."""
    drawn = {figure.name: figure for figure in content.figures}
    titles = {table.name: table.title for table in content.tables}
    found = {verdict.claim.name: verdict.verdict for verdict in content.verdicts}
    # By assumption the claims of which a point estimate leans another way under another choice.
    moved: dict[str, dict[str, None]] = {}
    for effect in content.effects:
        if effect.moved:
            moved.setdefault(effect.assumption, {})[effect.ours.claim.name] = None

    def figures(names: Sequence[str]) -> list[dict[str, str]]:
        shown = [drawn[name] for name in names if name in drawn]
        return [{"path": f"{one.name}.pdf", "title": one.title, "caption": one.caption} for one in shown]

    return {
        "title": content.paper.title,
        "subtitle": content.paper.subtitle,
        "made": f"Made from stored results of scale {content.results.scale or 'unknown'}; no result is typed.",
        "counts": [*counts_of_claims(content.verdicts).items()],
        "claims": [in_words(verdict) for verdict in content.verdicts if verdict.estimate.n],
        "not_run": [verdict.claim.name for verdict in content.verdicts if not verdict.estimate.n],
        "front_figures": figures(content.paper.front_figures),
        "sections": [
            {
                "title": section.title,
                "claims": [{"name": name, "verdict": found[name]} for name in section.claims if name in found],
                "parts": [{"heading": part.heading, "blocks": blocks(part.text)} for part in section.parts],
                "tables": [titles[name] for name in section.tables if name in titles],
                "figures": figures(section.figures[:FIGURES]),
            }
            for section in content.sections
        ],
        "assumptions": [
            {name: getattr(row, name).rstrip(".") for name in ("id", "quote", "problem", "choice")}
            | {"moves": ", ".join(moved[row.id])}
            for row in content.assumptions
            if row.id in moved
        ],
        "other_assumptions": [row.id for row in content.assumptions if row.id not in moved],
        "trials": figures((SENSITIVITY,)),
        **{Path(name).stem: blocks(content.texts.fill(name)) for name in content.texts.names(TEXTS)},
    }
