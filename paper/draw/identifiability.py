"""Singular values of the double pendulum's regression: what D shows, and what D_H does not."""

from typing import TYPE_CHECKING

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.results import Results
from repro.results.selectors import settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "dip_identifiability"
SEQUENCES = {"main": "D", "pretrain_only": "D_H with its energy", "joint": "D and D_H"}
BASES = {"fxf": "F⊗F", "fxf_gauge": "F⊗F with gauge terms"}
LEAST = 1e-17  # below rounding: zero is drawn here


def draw(results: Results) -> "Canvas | None":
    """Draw one panel per basis, one line per kind of data; None where nothing was examined."""
    if results.identifiability.empty:
        return None
    canvas = new_canvas(TEXT_WIDTH, 3.0)
    panels = canvas.subplots(1, len(BASES), sharey=True)
    drawn = {}
    for panel, (basis, title) in zip(panels, BASES.items(), strict=True):
        for (sequence, label), role in zip(SEQUENCES.items(), style.SERIES, strict=False):
            values = _spectrum(results, basis, sequence)
            if values.size:
                order = np.arange(1, values.size + 1)
                drawn[label] = panel.plot(order, np.maximum(values, LEAST), label=label, **role.marked_line_style)[0]
        panel.set_title(title)
        panel.set_yscale("log")
        panel.set_xlabel("direction")
    if not drawn:
        return None
    panels[0].set_ylabel("singular value / largest")
    canvas.legend(handles=[*drawn.values()], loc="outside upper left", ncols=len(drawn))
    return canvas


def _spectrum(results: Results, basis: str, sequence: str) -> np.ndarray:
    rows = results.identifiability
    for setting in settings(results, EXPERIMENT, {"basis": basis, "sequence": sequence}):
        seed, (run, _) = next(iter(setting.members.items()))
        own = rows[(rows["run"] == run) & (rows["member"] == seed)].sort_values("order")
        if len(own):
            return own["value"].to_numpy(dtype=float)
    return np.zeros(0)


FIGURES = (
    Figure(
        "identifiability",
        "What the data of the double pendulum show",
        "Singular values of the regression, columns scaled to unit norm, first member. Those at the level of rounding"
        " belong to combinations of terms that no sample shows: in F⊗F the two identities sin² + cos² = 1, and on D_H"
        " one more, the squared momentum of the cart, which is zero in all free motion from rest. Among the gauge "
        "terms the momentum itself stays unseen by both; at 1e-10 it shows how accurate the simulated D_H is, nothing"
        " else.",
        "One panel per basis: singular values from largest to smallest on a logarithmic axis; the last of them drop to "
        "the level of rounding.",
        draw,
    ),
)
