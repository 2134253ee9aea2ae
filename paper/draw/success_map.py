"""Which random starts succeed: one panel per setting and model, one dot per closed loop."""

from typing import TYPE_CHECKING

import numpy as np

from repro.report.figures.figure import Figure, legend, small_multiples
from repro.report.style import Role
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.table_schema import as_text, plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

# Others vary what no title says: the weights of a cost, the data of a fit. What these vary beside KEYS are the starts.
EXPERIMENTS = ("sip_control", "dip_control", "control_robustness")
KEYS = ("setting", "model", "basis", "mismatch", "mismatch_kind", "noise", "disturbance", "delay", "friction")
COLUMNS = 4
OUTCOMES = {
    "erect": Role("#10305c", "-", "o"),
    "not erect": Role("#e2680a", "-", "x"),
    "contact": Role("#b0478f", "-", "^"),
}


def draw(results: Results) -> "Canvas | None":
    """Draw every setting of EXPERIMENTS that was started at random."""
    control = results.control
    loops = control[(control["task"] == "random") & control["experiment"].isin(EXPERIMENTS)]
    groups = [group for _, group in loops.groupby([loops[key].map(_text) for key in KEYS], sort=False)]
    if not groups:
        return None
    canvas, panels = small_multiples(len(groups), COLUMNS, 1.5, 0.5)
    for panel, group in zip(panels, groups, strict=True):
        double = group["start_theta1"].notna().any()
        across, up = ("start_theta1", "start_theta2") if double else ("start_theta", "start_x")
        for name, role in OUTCOMES.items():
            chosen = group[_outcome(group) == name]
            angles = np.degrees(chosen[across].to_numpy(dtype=float))
            heights = chosen[up].to_numpy(dtype=float)
            panel.plot(angles, np.degrees(heights) if double else heights, markersize=3, **role.marker_style)
        panel.set_title(_title(group), fontsize=6.5, fontweight="normal")
        panel.tick_params(labelsize=6)
        panel.set_xlabel("θ₁ [deg]" if double else "θ [deg]", fontsize=6.5)
        panel.set_ylabel("θ₂ [deg]" if double else "x [m]", fontsize=6.5)
    legend(canvas, panels[0], OUTCOMES)
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
    text = ", ".join(part for part in conditions if part)
    successes = int(group["success"].sum())
    return f"{written('setting', first['setting'])}, {model}\n{text or 'nominal'}\n{successes} of {len(group)}"


def _text(value: object) -> str:
    return as_text(plain(value))


FIGURES = (
    Figure(
        "success_map",
        "Which random starts succeed",
        "One dot per closed loop at its initial state: angles around hanging (180 degrees), and the cart's position for"
        " one link. The title counts the successes: erect for the last 2 s and no contact.",
        "One panel per controller: initial states as dots, filled where the loop succeeds, open where it fails.",
        draw,
    ),
)
