"""Peers under one protocol: the error of accelerations against the CPU time of a fit, a line per method."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import Where, settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "related_work"
SYSTEMS = {"sip": "cart-pole", "dip": "double pendulum on a cart"}
PLAIN: Where = {"labels": "exact", "tau_noise": 0.0, "n_train": 1000, "control": ""}
METHODS: Mapping[str, Where] = {
    "ours: structured, LM": {"model": "structured", "optimiser": "levenberg_marquardt"},
    "MLP": {"model": "blackbox", "objective": "forward", "optimiser": "adam_budget"},
    "neural ODE": {"model": "blackbox", "objective": "prediction"},
    "LNN": {"basis": "engineered", "optimiser": "adam_budget"},
    "DeLaN": {"model": "structured", "objective": "inverse", "optimiser": "adam_budget"},
    "DeLaN with energy": {"model": "structured", "objective": "mixed"},
    "HNN, p given": {"model": "hamiltonian", "model.dissipation": "none", "optimiser": "adam_budget"},
    "SymODEN": {"model": "symoden", "model.dissipation": "none", "optimiser": "adam_budget"},
    "SINDy-PI": {"model": "sparse", "model.form": "implicit"},
}


def draw(results: Results) -> "Canvas | None":
    """Draw medians over the seeds, with the range of all seeds as a bar; one panel per system."""
    found = {
        system: {
            name: settings(results, EXPERIMENT, {**PLAIN, **where, "system": system}) for name, where in METHODS.items()
        }
        for system in SYSTEMS
    }
    shown = [system for system, groups in found.items() if any(groups.values())]
    if not shown:
        return None
    from matplotlib.ticker import LogLocator, NullFormatter

    canvas = new_canvas(TEXT_WIDTH, 2.9)
    panels = canvas.subplots(1, len(shown), squeeze=False)[0]
    for system, panel in zip(shown, panels, strict=True):
        for (name, group), role in zip(found[system].items(), style.SERIES, strict=True):
            _line(panel, group, name, role.marked_line_style)
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.xaxis.set_major_locator(LogLocator())
        panel.xaxis.set_major_formatter("{x:g}")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.set_xlabel("CPU time of a fit [s]")
        panel.set_title(SYSTEMS[system])
    panels[0].set_ylabel("MAE q̈ [m/s², rad/s²]")
    canvas.legend(handles=panels[0].lines, loc="outside lower center", ncols=5)
    return canvas


def _line(panel: Any, group: list[RunSetting], name: str, looks: Mapping[str, Any]) -> None:
    points = []
    for setting in group:
        seconds, errors = setting.values("fit_seconds"), setting.values("mae_qdd")
        if errors.size:
            points.append((float(np.median(seconds)), *np.quantile(errors, (0.5, 0.0, 1.0))))
    if points:
        at, middle, low, high = np.array(sorted(points)).T
        panel.plot(at, middle, label=name, **looks)
        panel.vlines(at, low, high, color=looks["color"], linewidth=0.6)
    else:
        panel.plot([], [], label=name, **looks)


FIGURES = (
    Figure(
        "related_work",
        "Peers under one protocol",
        "Exact accelerations, 1,000 samples: medians over the seeds against the CPU time of a fit, all seeds within "
        "the thin bars. A line that still falls at its end is of a method that is not trained to its end.",
        "Two panels with logarithmic axes: the error of accelerations against CPU seconds, one line per method.",
        draw,
    ),
)
