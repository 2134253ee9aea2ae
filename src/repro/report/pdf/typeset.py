"""The report as a PDF, by typst: no program beside Python is needed, and the same content gives the same bytes."""

import json
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from repro.report.pdf.document import document
from repro.report.sections import Content
from repro.tracking.files import replacing

ENTRY = "report.typ"


def write_pdf(content: Content, figures: Path, source: Path, target: Path) -> None:
    """Typeset the content with the template in `source` (paper/report) and write the PDF atomically.

    `figures` holds the drawn figures as PDF files. Raises UserError for a mistake in a text.
    """
    body = document(content)
    with replacing(target) as temporary:
        temporary.write_bytes(typeset(body, figures, source))


def typeset(body: Mapping[str, Any], figures: Path, source: Path) -> bytes:
    """Return the PDF of a document. Nothing outside of the two folders and the bundled fonts is read."""
    import typst

    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for path in (*source.glob("*.typ"), *source.glob("*.yaml"), *figures.glob("*.pdf")):
            shutil.copyfile(path, place / path.name)
        (place / "content.json").write_text(json.dumps(body, ensure_ascii=False), encoding="utf-8")
        return typst.compile(place / ENTRY, root=place, ignore_system_fonts=True)
