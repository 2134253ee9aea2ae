"""One page that holds the viewer and some recordings: it opens from disk and needs neither server nor network."""

import base64
import gzip
from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup

from repro.report.html.environment import ASSETS, rendered
from repro.tracking.files import write_text

NAME = "interactive.html"


def write_interactive(recordings: Sequence[Path], folder: Path) -> Path:
    """Write interactive.html beside a report's pages; `recordings` are .rrd files. Return its path.

    Raises UserError when the viewer gives no web pages. About 19 MB, plus 4/3 of the recordings.
    """
    from repro.recording.viewer import web_viewer

    script, program = web_viewer()
    text = rendered(
        "interactive.html",
        recordings=[{"run": path.parent.name, "content": _text(path.read_bytes())} for path in recordings],
        viewer=_own(script),
        program=_text(gzip.compress(program, mtime=0)),
        style=_own((ASSETS / "report.css").read_text(encoding="utf-8")),
    )
    write_text(folder / NAME, text)
    return folder / NAME


def _text(content: bytes) -> str:
    return base64.b64encode(content).decode()


def _own(text: str) -> Markup:
    """Mark a script or a style as fit to embed; what would end its element early is spelt otherwise."""
    return Markup(text.replace("</", r"<\/"))
