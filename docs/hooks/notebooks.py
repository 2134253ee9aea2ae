"""Makes pages of docs/notebooks/*.py: cells as in jupytext's percent format, with what they show."""

import ast
import base64
import io
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"
CELL = re.compile(r"^# %%(?P<kind> \[markdown\])?\n(?P<text>.*?)(?=^# %%|\Z)", re.MULTILINE | re.DOTALL)


def on_files(files: "Files", config: "MkDocsConfig") -> "Files":
    """Add a page for each notebook, made by running it."""
    from mkdocs.structure.files import File

    for path in sorted(FOLDER.glob("*.py")):
        files.append(File.generated(config, f"notebooks/{path.stem}.md", content=page(path)))
    return files


def page(path: Path) -> str:
    """The notebook as Markdown: its text, its code, and the value of the last expression of each cell."""
    names: dict[str, Any] = {"__name__": "__main__"}
    parts = []
    for cell in CELL.finditer(path.read_text(encoding="utf-8")):
        text = cell["text"].strip("\n")
        if cell["kind"]:
            parts.append(re.sub(r"^# ?", "", text, flags=re.MULTILINE))
        else:
            parts += [f"```python\n{text}\n```", _shown(_run(text, path, names))]
    return "\n\n".join(part for part in parts if part) + "\n"


def _run(text: str, path: Path, names: dict[str, Any]) -> Any:
    """Run a cell and return the value of its last expression, or None."""
    tree = ast.parse(text)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, str(path), "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), str(path), "eval"), names)


def _shown(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, Figure):
        picture = io.BytesIO()
        value.savefig(picture, format="png", dpi=110)
        return f"![what the cell draws](data:image/png;base64,{base64.b64encode(picture.getvalue()).decode()})"
    if hasattr(value, "_repr_html_"):
        return f"<div>{value._repr_html_()}</div>"
    return f"```text\n{value!r}\n```"
