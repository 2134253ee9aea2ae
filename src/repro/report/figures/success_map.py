"""Which random starts succeed: one panel a setting and model, one dot a closed loop."""

from typing import TYPE_CHECKING

import numpy as np

from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.schema import as_text, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

KEYS = ("setting", "model", "basis", "mismatch", "mismatch_kind", "noise", "disturbance", "delay", "friction")
COLUMNS = 4
OUTCOMES = {"erect": ("#10305c", "o"), "not erect": ("#e2680a", "x"), "contact": ("#b0478f", "^")}


def draw(results: Results) -> "Canvas | None":
    """Draw every setting that was started at random."""
    loops = results.control[results.control["task"] == "random"]
    groups = [group for _, group in loops.groupby([loops[key].map(_text) for key in KEYS], sort=False)]
    if not groups:
        return None
    rows = -(-len(groups) // COLUMNS)
    canvas = new_canvas(TEXT_WIDTH, 0.5 + 1.5 * rows)
    panels = np.atleast_1d(canvas.subplots(rows, COLUMNS, squeeze=False)).ravel()
    for panel, group in zip(panels, groups, strict=False):
        double = group["start_theta1"].notna().any()
        across, up = ("start_theta1", "start_theta2") if double else ("start_theta", "start_x")
        for name, (colour, marker) in OUTCOMES.items():
            chosen = group[_outcome(group) == name]
            angles = np.degrees(chosen[across].to_numpy(dtype=float))
            heights = chosen[up].to_numpy(dtype=float)
            panel.plot(angles, np.degrees(heights) if double else heights, marker, color=colour, markersize=3)
        panel.set_title(_title(group), fontsize=6.5, fontweight="normal")
        panel.tick_params(labelsize=6)
        panel.set_xlabel("θ₁ [deg]" if double else "θ [deg]", fontsize=6.5)
        panel.set_ylabel("θ₂ [deg]" if double else "x [m]", fontsize=6.5)
    for panel in panels[len(groups) :]:
        panel.set_visible(False)
    handles = [panels[0].plot([], [], m, color=c, label=name)[0] for name, (c, m) in OUTCOMES.items()]
    canvas.legend(handles=handles, loc="outside upper left", ncols=len(handles))
    return canvas


def _outcome(group: "pd.DataFrame") -> np.ndarray:
    words = np.where(group["success"].to_numpy(dtype=bool), "erect", "not erect")
    return np.where(group["contact"].to_numpy(dtype=bool), "contact", words)


def _title(group: "pd.DataFrame") -> str:
    first = {key: plain(group[key].iloc[0]) for key in KEYS}
    model = written("basis", first["basis"]) if first["basis"] else written("model", first["model"])
    conditions = [
        f"±{100 * first['mismatch']:g} % {first['mismatch_kind']}" if first["mismatch"] else "",
        f"noise {first['noise']:g}" if first["noise"] else "",
        f"push {first['disturbance']:g} N" if first["disturbance"] else "",
        f"delay {1e3 * first['delay']:g} ms" if first["delay"] else "",
        "friction" if first["friction"] else "",
    ]
    told = ", ".join(part for part in conditions if part)
    successes = int(group["success"].sum())
    return f"{written('setting', first['setting'])}, {model}\n{told or 'nominal'}\n{successes} of {len(group)}"


def _text(value: object) -> str:
    return as_text(plain(value))


FIGURE = Figure(
    "success_map",
    "Which random starts succeed",
    "One dot a closed loop at its initial state: angles around hanging (180 degrees), and the cart's position for one "
    "link. The title counts the successes: erect for the last 2 s and no contact.",
    draw,
)
