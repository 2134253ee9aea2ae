"""What every figure is: a name, a title, a caption, a text alternative, and how to draw it from results."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from repro.report import style
from repro.report.style import TEXT_WIDTH, Role
from repro.results.results import Results
from repro.tracking.files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas
else:
    Canvas = TypeVar("Canvas")  # for annotations alone: matplotlib is loaded where a figure is drawn


@dataclass(frozen=True)
class Figure:
    """One figure; `alt` is its text alternative; `draw` returns None without data."""

    name: str
    title: str
    caption: str
    alt: str
    draw: Callable[[Results], Canvas | None]

    def save(self, results: Results, folder: Path) -> bool:
        """Draw and write <name>.pdf and <name>.png, each atomically; return whether there was anything to show."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        with style.applied(), _glyphs_alone():
            canvas = self.draw(results)
            if canvas is None:
                return False
            # Without a date the same results give the same file. Figure.savefig would draw each file twice.
            with replacing(folder / f"{self.name}.pdf", forced=False) as temporary:
                FigureCanvasPdf(canvas).print_pdf(temporary, metadata={"CreationDate": None})
            # The first drawing has laid the figure out; laying it out again costs as much as drawing.
            canvas.set_layout_engine("none")
            canvas.set_dpi(style.RESOLUTION)
            with replacing(folder / f"{self.name}.png", forced=False) as temporary:
                FigureCanvasAgg(canvas).print_png(temporary, metadata={"Software": None})
        return True


@contextmanager
def _glyphs_alone() -> Iterator[None]:
    """Embed fonts without the tables that lay text out: a PDF places every glyph, and to read them takes longest."""
    from fontTools.subset import Options

    dropped: list[str] = vars(Options)["_drop_tables_default"]  # there is no public name for it
    before = [*dropped]
    dropped += ["GDEF", "GPOS", "GSUB", "kern"]
    try:
        yield
    finally:
        dropped[:] = before


def new_canvas(width: float, height: float) -> Canvas:
    """Return an empty figure of this size in inches, outside of pyplot's list of open figures."""
    from matplotlib.figure import Figure as Canvas

    return Canvas(figsize=(width, height))


def small_multiples(
    count: int, columns: int, row_height: float, extra: float, *, share_y: bool = False
) -> tuple[Canvas, list[Any]]:
    """Return a canvas of the text's width with `count` panels in rows of `columns`; heights in inches."""
    rows = -(-count // columns)
    canvas = new_canvas(TEXT_WIDTH, extra + row_height * rows)
    panels: list[Any] = canvas.subplots(rows, columns, squeeze=False, sharey=share_y).ravel().tolist()
    for panel in panels[count:]:
        panel.remove()
    return canvas, panels[:count]


def legend(
    canvas: Canvas,
    panel: Any,
    roles: Mapping[str, Role],
    *,
    lines: Mapping[str, Role] | None = None,
    columns: int = 3,
) -> None:
    """Name roles above the panels: those that are drawn as markers, then those that are drawn as lines."""
    entries = [panel.plot([], [], label=label, **role.marker_style)[0] for label, role in roles.items()]
    entries += [panel.plot([], [], label=label, **role.line_style)[0] for label, role in (lines or {}).items()]
    canvas.legend(handles=entries, loc="outside upper left", ncols=min(columns, len(entries)))
