"""What every figure is: a name, a title, a caption, and how to draw it from results."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from repro.report import style
from repro.results.results import Results
from repro.tracking.files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas


@dataclass(frozen=True)
class Figure:
    """One figure; `draw` gives None where the results hold nothing to show."""

    name: str
    title: str
    caption: str
    draw: Callable[[Results], "Canvas | None"]

    def save(self, results: Results, folder: Path) -> bool:
        """Draw and write <name>.pdf and <name>.png, each atomically; say whether there was anything to show."""
        with style.applied():
            canvas = self.draw(results)
            if canvas is None:
                return False
            # Without a date the same results give the same file.
            for suffix, metadata in {".pdf": {"CreationDate": None}, ".png": {"Software": None}}.items():
                with replacing(folder / f"{self.name}{suffix}", keep_suffix=True) as temporary:
                    canvas.savefig(temporary, metadata=metadata)
                # The first drawing has laid the figure out; laying it out again costs as much as drawing.
                canvas.set_layout_engine("none")
        return True


def new_canvas(width: float, height: float) -> "Canvas":
    """Return an empty figure of this size in inches, outside of pyplot's list of open figures."""
    from matplotlib.figure import Figure as Canvas

    return Canvas(figsize=(width, height))
