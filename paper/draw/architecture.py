"""Counterparts of the paper's Figs. 1 to 3, drawn from what the models consist of (architecture.json)."""

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.results import Results

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
LINE = 0.15  # inches per line of text
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


PORT_FORM = (
    r"$\dot{\hat x} = (\hat J - \hat R)\,\partial\hat H/\partial x + g u$"
    "\n"
    r"$y = g^\top\,\partial\hat H/\partial x$"
)
MATRICES_WIDTH = 1.75  # inches for J and R at the right of Fig. 3


def draw_framework(_results: Results) -> "Canvas":
    """Draw Fig. 1: from data over the Lagrangian to port-Hamiltonian form, and to interconnections."""
    parts = _architecture()
    plnn, port = parts["plnn"], parts["port"]
    resistance = port["L below"]["weights"] + port["L diagonal"]["weights"]
    columns = [
        [Box("data", "data\n$q, \\dot q, \\ddot q, \\tau$", "data")],
        [
            Box("T", f"$\\hat T$\n{plnn['T']['weights']} weights", "learned"),
            Box("V", f"$\\hat V$\n{plnn['V']['weights']} weight", "learned"),
        ],
        [Box("L", "$\\hat L = \\hat T - \\hat V$")],
        [
            Box("p", "$\\hat p = \\partial\\hat L/\\partial\\dot q$\n$x = [q; \\hat p]$"),
            Box("H", "$\\hat H = \\hat p^\\top\\dot q - \\hat L$"),
        ],
        [
            Box("J", f"$\\hat J = A - A^\\top$\n{port['A']['weights']} weights", "learned"),
            Box("port", PORT_FORM),
            Box("R", f"$\\hat R = L_{{mat}}L_{{mat}}^\\top$\n{resistance} weights", "learned"),
        ],
        [
            Box("other", "other subsystems\n$\\hat H_2, \\ldots$", "data"),
            Box("whole", "interconnection\n$\\hat H_I = \\sum_i \\hat H_i$"),
        ],
    ]
    arrows = [
        *(Arrow("data", name) for name in ("T", "V")),
        *(Arrow(name, "L") for name in ("T", "V")),
        *(Arrow("L", name, dashed=True) for name in ("p", "H")),
        *(Arrow(name, "port") for name in ("p", "H", "J", "R")),
        *(Arrow(name, "whole") for name in ("port", "other")),
    ]
    return diagram(columns, arrows, TEXT_WIDTH + 1.4, 2.3)


def draw_plnn(_results: Results) -> "Canvas":
    """Draw Fig. 2: the networks of the PLNN with their inputs and sizes, what is derived from them, and the losses."""
    parts = _architecture()
    plnn = parts["plnn"]
    names = {part: _spelled(plnn[part]["inputs"], parts["coordinates"]) for part in ("T", "V", "M")}
    columns = [
        [Box(f"{part} inputs", f"features of $\\hat {part}$\n{text}", "data") for part, text in names.items()],
        [
            _network_box("T", "$\\hat T$", plnn["T"]),
            Box("V", f"$\\hat V = \\beta$ · features\n{plnn['V']['weights']} weight", "learned"),
            _network_box("M", "$\\hat M(q)$", plnn["M"]),
        ],
        [
            Box("sum", "$\\hat H = \\hat T + \\hat V$"),
            Box("L", "$\\hat L = \\hat T - \\hat V$"),
            Box("p tran", "$\\hat p_{tran} = \\hat M(q)\\,\\dot q$"),
        ],
        [
            Box("tau", "$\\hat\\tau$, eq. (7b)"),
            Box("p", "$\\hat p = \\partial\\hat L/\\partial\\dot q$"),
        ],
        [
            Box("loss H", "$|H_0 - \\hat H|^2$\non $D_H$", "loss"),
            Box("loss tau", "$\\|\\tau - \\hat\\tau\\|^2$\n$+\\,\\lambda_T|\\alpha| + \\lambda_V|\\beta|$", "loss"),
            Box("loss p", "$\\Omega_{tran} =$\n$\\|\\hat p_{tran} - \\hat p\\|^2$", "loss"),
        ],
    ]
    arrows = [
        *(Arrow(f"{part} inputs", part) for part in names),
        *(Arrow(part, end) for part in ("T", "V") for end in ("sum", "L")),
        Arrow("M", "p tran"),
        *(Arrow("L", end, dashed=True) for end in ("tau", "p")),
        Arrow("sum", "loss H"),
        Arrow("tau", "loss tau"),
        *(Arrow(start, "loss p") for start in ("p", "p tran")),
    ]
    return diagram(columns, arrows, TEXT_WIDTH, 3.5)


def draw_matrices(_results: Results) -> "Canvas":
    """Draw Fig. 3: the three networks behind J and R, and both matrices at their starting weights."""
    parts = _architecture()
    port, height = parts["port"], 3.7
    state = f"state\n{_spelled(port['A']['inputs'], parts['coordinates'])}"
    columns = [
        [Box("x", state, "data")],
        [
            _network_box("A", "$A$ below its diagonal", port["A"]),
            _network_box("below", "$L_{mat}$ below its diagonal", port["L below"]),
            _network_box("diagonal", "$L_{mat}$, diagonal $d_i \\geq 0$", port["L diagonal"]),
        ],
        [Box("J", "$\\hat J = A - A^\\top$"), Box("R", "$\\hat R = L_{mat}L_{mat}^\\top$")],
    ]
    arrows = [
        *(Arrow("x", name) for name in ("A", "below", "diagonal")),
        Arrow("A", "J"),
        *(Arrow(name, "R") for name in ("below", "diagonal")),
    ]
    canvas = diagram(columns, arrows, TEXT_WIDTH, height, beside=MATRICES_WIDTH)
    size = 1.25
    left = (TEXT_WIDTH - MATRICES_WIDTH + 0.3) / TEXT_WIDTH
    for name, bottom in (("J", 2.05), ("R", 0.25)):
        panel = canvas.add_axes((left, bottom / height, size / TEXT_WIDTH, size / height))
        _matrix(panel, name, np.array(port[name]))
    return canvas


def _matrix(panel: Any, name: str, matrix: np.ndarray) -> None:
    greatest = np.abs(matrix).max()
    panel.imshow(matrix, cmap="PuOr", vmin=-1.3 * greatest, vmax=1.3 * greatest)
    for (row, column), value in np.ndenumerate(matrix):
        colour = "white" if abs(value) > 0.6 * greatest else "black"
        text = f"{value:.2f}".replace("-", "−")
        panel.text(column, row, text, ha="center", va="center", fontsize=6, color=colour)
    panel.set_title(f"$\\hat {name}$ as built")
    panel.set_xticks([])
    panel.set_yticks([])
    panel.grid(visible=False)
    for side in panel.spines.values():
        side.set_visible(True)
        side.set_color(style.PAPER.colour)


def _network_box(name: str, title: str, part: Mapping[str, Any]) -> Box:
    layers = tuple(part["layers"])
    text = f"{title}\n{'-'.join(map(str, layers))} {part['activation']}\n{part['weights']} weights"
    return Box(name, text, "learned", layers)


def _spelled(inputs: Sequence[str], coordinates: Sequence[str]) -> str:
    """Spell features for people: qd0 is the rate of the first coordinate, cos(q1) a function of the second."""
    texts = []
    for name in inputs:
        function, _, _ = name.partition("(")
        symbol = coordinates[int(name.rstrip(")")[-1])].replace("θ", r"\theta")
        if name.startswith("qd"):
            texts.append(rf"$\dot {{{symbol}}}$")
        else:
            texts.append(rf"$\{function}\,{symbol}$")
    return ", ".join(texts)


def _architecture() -> dict[str, Any]:
    path = Path(__file__).with_name("architecture.json")
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


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


FIGURES = (
    Figure(
        "framework",
        "From data to interconnected port-Hamiltonian models (Fig. 1)",
        "Sizes are those of the models as built, for the single pendulum. Blue: learned; white: derived; dashed "
        "arrows: by differentiation; grey: given.",
        "Flow chart: data, two energies, the Lagrangian, momentum and Hamiltonian, the port-Hamiltonian model, and "
        "its interconnection with others.",
        draw_framework,
    ),
    Figure(
        "plnn",
        "The PLNN and its regularisers (Fig. 2)",
        "The network on T2/V1 with 1x10 units, and the momentum network beside it. One dot is a unit, one line a "
        "weight; dashed arrows stand for derivatives, orange boxes for losses.",
        "Drawing of a small network with its inputs and outputs, a momentum network beside it, and three losses.",
        draw_plnn,
    ),
    Figure(
        "port_matrices",
        "The networks behind J(x) and R(x) (Fig. 3)",
        "Three networks, and the matrices that they make at their starting weights and one state: skew and positive "
        "semi-definite before any training.",
        "Three small networks of the state, and the skew J and symmetric R that they make, as grids.",
        draw_matrices,
    ),
)
