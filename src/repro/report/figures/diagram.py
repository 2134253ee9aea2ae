"""Diagrams of boxes and arrows: columns from left to right, the boxes of a column spread evenly."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from repro.report import style
from repro.report.figures.figure import new_canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

Kind = Literal["data", "learned", "computed", "loss"]
FACES: Mapping[Kind, str] = {"data": "#e9e9e9", "learned": "#dce6f4", "computed": "white", "loss": "#fdeee2"}
EDGES: Mapping[Kind, str] = {
    "data": style.PAPER.colour,
    "learned": style.PLANT.colour,
    "computed": style.PLANT.colour,
    "loss": style.MODEL.colour,
}
Place = tuple[float, float, float, float]  # left, bottom, width, height
LINE = 0.15  # inches a line of text
NETWORK = 0.52  # inches a drawn network
MARGIN = 0.05  # inches around a diagram
GAP = 0.26  # inches between columns, for the arrows


@dataclass(frozen=True)
class Box:
    """One box; `layers` draws a network of these sizes below its text."""

    name: str
    text: str
    kind: Kind = "computed"
    layers: tuple[int, ...] = ()

    @property
    def height(self) -> float:
        """Height in inches."""
        return 0.16 + LINE * (self.text.count("\n") + 1) + (NETWORK if self.layers else 0.0)


@dataclass(frozen=True)
class Arrow:
    """From one box to another; `dashed` where it stands for automatic differentiation."""

    start: str
    end: str
    dashed: bool = False


def diagram(
    columns: Sequence[Sequence[Box]], arrows: Sequence[Arrow], width: float, height: float, beside: float = MARGIN
) -> "Canvas":
    """Draw columns of boxes, and the arrows between them, on a canvas of this size in inches.

    `beside` inches stay free at the right.
    """
    canvas = new_canvas(width, height)
    canvas.set_layout_engine("none")
    axis = canvas.add_axes((0, 0, 1, 1))
    axis.set_xlim(0, width)
    axis.set_ylim(0, height)
    axis.axis("off")
    wide = (width - MARGIN - beside - GAP * (len(columns) - 1)) / len(columns)
    places: dict[str, Place] = {}
    for number, column in enumerate(columns):
        x = MARGIN + number * (wide + GAP)
        free = (height - 2 * MARGIN - sum(box.height for box in column)) / (len(column) + 1)
        y = height - MARGIN
        for box in column:
            y -= free + box.height
            _draw(axis, box, x, y, wide)
            places[box.name] = (x, y, wide, box.height)
    for arrow in arrows:
        _connect(axis, places[arrow.start], places[arrow.end], arrow.dashed)
    return canvas


def _draw(axis: Any, box: Box, x: float, y: float, wide: float) -> None:
    from matplotlib.patches import FancyBboxPatch

    shape = "round,pad=0,rounding_size=0.06"
    axis.add_patch(
        FancyBboxPatch((x, y), wide, box.height, shape, facecolor=FACES[box.kind], edgecolor=EDGES[box.kind])
    )
    text_height = box.height - (NETWORK if box.layers else 0.0)
    axis.text(x + wide / 2, y + box.height - text_height / 2, box.text, ha="center", va="center", fontsize=7)
    if box.layers:
        _network(axis, box.layers, (x + 0.12, y + 0.07, x + wide - 0.12, y + NETWORK))


def _network(axis: Any, layers: Sequence[int], area: tuple[float, float, float, float]) -> None:
    """Draw one dot a unit and one line a weight."""
    left, bottom, right, top = area
    step = (right - left) / (len(layers) - 1)
    spread = min(0.075, (top - bottom) / max(layers))
    middle = (top + bottom) / 2
    dots = [
        [(left + step * place, middle + spread * (unit - (units - 1) / 2)) for unit in range(units)]
        for place, units in enumerate(layers)
    ]
    for before, after in itertools.pairwise(dots):
        for start in before:
            for end in after:
                axis.plot(*zip(start, end, strict=True), color=style.PLANT.colour, linewidth=0.25, alpha=0.6)
    for layer in dots:
        axis.plot(*zip(*layer, strict=True), "o", color=style.PLANT.colour, markersize=2.2)


def _connect(axis: Any, start: Place, end: Place, dashed: bool) -> None:
    x, y, wide, high = start
    if x != end[0]:  # in another column
        ends = (x + wide, y + high / 2), (end[0], end[1] + end[3] / 2)
    elif y > end[1]:
        ends = (x + wide / 2, y), (x + wide / 2, end[1] + end[3])
    else:
        ends = (x + wide / 2, y + high), (x + wide / 2, end[1])
    line = {"linewidth": 0.9, "linestyle": (0, (3, 1.5)) if dashed else "-", "color": style.PAPER.colour}
    head = {"arrowstyle": "-|>", "shrinkA": 1, "shrinkB": 1, "mutation_scale": 8}
    axis.annotate("", xytext=ends[0], xy=ends[1], arrowprops=line | head)
