"""Composition: the error against the number of samples, composed and from scratch; chains against their length."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.results import Results
from repro.report.selection import Where, settings
from repro.report.setting import Setting
from repro.report.style import TEXT_WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT, CHAINS = "composition", "chains"
NOISE = 0.1
CURVES: Mapping[str, Where] = {
    "all of L from scratch": {"model": "lagrangian", "tau_noise": NOISE},
    "trained part + full basis": {"model": "extended", "options": "parts=['cart_rod_noisy'], rest=basis"},
    "trained part + rigid body": {"model": "hinged", "options": "parts=['cart_rod_noisy'], rod=rigid_body"},
    "trained part + one mass": {"model": "hinged", "options": "parts=['cart_rod_noisy'], rod=mass"},
}
METRICS = {"mae_tau": "MAE τ [N, N m]", "mae_H_centred": "MAE H centred [J]"}
LINKS = (2, 10, 100, 1000, 10000)


def draw_samples(results: Results) -> "Canvas | None":
    """Draw one panel a metric, one line a way to make the model: the median over members, and every member."""
    found = {label: settings(results, EXPERIMENT, where) for label, where in CURVES.items()}
    if not any(found.values()):
        return None
    canvas = new_canvas(TEXT_WIDTH, 3.0)
    panels = canvas.subplots(1, len(METRICS))
    drawn = {}
    for panel, (metric, title) in zip(panels, METRICS.items(), strict=True):
        for (label, those), role in zip(found.items(), style.SERIES, strict=False):
            points = [(s.card["n_train"], s.values(metric)) for s in sorted(those, key=_samples)]
            points = [(n, values) for n, values in points if values.size]
            if not points:
                continue
            numbers, medians = [n for n, _ in points], [np.median(values) for _, values in points]
            look = role.line_style | role.marker_style | {"linestyle": role.line}
            drawn[label] = panel.plot(numbers, medians, label=label, **look)[0]
            for n, values in points:
                panel.plot([n] * values.size, values, alpha=0.3, markersize=2, **role.marker_style)
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_title(title)
        panel.set_xlabel("samples of the double pendulum")
    canvas.legend(handles=[*drawn.values()], loc="outside lower center", ncols=2)
    return canvas


def draw_chains(results: Results) -> "Canvas | None":
    """Draw the state error and the cost against the number of links, one line a setting."""
    found = [s for s in settings(results, CHAINS) if any(s.values(f"chain_error_{n}").size for n in LINKS)]
    if not found:
        return None
    canvas = new_canvas(TEXT_WIDTH, 2.8)
    panels = canvas.subplots(1, 2)
    drawn = {}
    for panel, (name, title) in zip(
        panels, {"error": "relative state error after 10 s", "seconds": "processor time [s]"}.items(), strict=True
    ):
        for setting, role in zip(found, style.SERIES, strict=False):
            measured = [(n, setting.values(f"chain_{name}_{n}")) for n in LINKS]
            points = [(n, float(np.median(values))) for n, values in measured if values.size]
            look = role.line_style | role.marker_style | {"linestyle": role.line}
            label = f"noise {setting.card['tau_noise']:g} N, {setting.card['n_train']} samples"
            drawn[label] = panel.plot(*zip(*points, strict=True), label=label, **look)[0]
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_title(title)
        panel.set_xlabel("links")
    canvas.legend(handles=[*drawn.values()], loc="outside lower center", ncols=2)
    return canvas


def _samples(setting: Setting) -> int:
    return int(setting.card["n_train"])


SAMPLES = Figure(
    "composition",
    "A double pendulum of trained sub-models, and from scratch",
    "Noise of 0.1 N on every force; the cart with its rod was trained on 80,000 samples of its own with the same noise "
    "and is frozen. Lines are medians, dots members. Beside a full basis the trained part adds nothing: it lies in the "
    "basis. What is known of the rest is what helps.",
    draw_samples,
)
LENGTHS = Figure(
    "chains",
    "Chains of a link that was learned once",
    "Relative error of all extensions and momenta against the true chain, and the cost of building and simulating it.",
    draw_chains,
)
