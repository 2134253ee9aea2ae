"""Composition: the error against the number of samples, composed and from scratch; chains against their length."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import Where, settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

EXPERIMENT, CHAINS = "composition", "chains"
NOISE = 0.1
NOISY_PART = {"model.parts": "[cart_rod_noisy]"}
CURVES: Mapping[str, Where] = {
    "all of L from scratch": {"model": "lagrangian", "tau_noise": NOISE},
    "trained part + full basis": {"model": "extended", **NOISY_PART, "model.rest": "basis"},
    "trained part + rigid body": {"model": "hinged", **NOISY_PART, "model.rod": "rigid_body"},
    "trained part + one mass": {"model": "hinged", **NOISY_PART, "model.rod": "mass"},
}
METRICS = {"mae_tau": "MAE τ [N, N m]", "mae_H_centred": "MAE H centred [J]"}
CHAIN_LABEL = "{model}, noise {noise} N, {n} samples"
LINKS = (2, 5, 10, 30, 100, 1000, 10000)


def draw_samples(results: Results) -> "Canvas | None":
    """Draw one panel per metric, one line per way to make the model: the median over members, and every member."""
    groups = {label: settings(results, EXPERIMENT, where) for label, where in CURVES.items()}
    if not any(groups.values()):
        return None
    canvas = new_canvas(TEXT_WIDTH, 3.0)
    panels = canvas.subplots(1, len(METRICS))
    drawn = {}
    for panel, (metric, title) in zip(panels, METRICS.items(), strict=True):
        for (label, group), role in zip(groups.items(), style.SERIES, strict=False):
            points = [(s.card["n_train"], s.values(metric)) for s in sorted(group, key=_samples)]
            points = [(n, values) for n, values in points if values.size]
            if not points:
                continue
            numbers, medians = [n for n, _ in points], [np.median(values) for _, values in points]
            drawn[label] = panel.plot(numbers, medians, label=label, **role.marked_line_style)[0]
            for n, values in points:
                panel.plot([n] * values.size, values, alpha=0.3, markersize=2, **role.marker_style)
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_title(title)
        panel.set_xlabel("samples of the double pendulum")
    canvas.legend(handles=[*drawn.values()], loc="outside lower center", ncols=2)
    return canvas


def draw_chains(results: Results) -> "Canvas | None":
    """Draw the state error of composed chains, and of chains learned as a whole, and the cost, against the links."""
    measured = [s for s in settings(results, CHAINS) if _along(s, "chain_error")]
    compared = [setting for setting in measured if _along(setting, "whole_chain_error")]
    composed = [setting for setting in measured if setting not in compared]
    if not composed:
        return None
    canvas = new_canvas(TEXT_WIDTH, 3.2)
    error, *between, cost = canvas.subplots(1, 3 if compared else 2)
    _lines(error, composed, "chain_error", "state error after 10 s")
    _lines(cost, composed, "chain_seconds", "processor time [s]")
    for panel in between:
        _lines(panel, compared, "chain_error", "… and learned as a whole", "composed, {n} samples")
        _lines(panel, compared, "whole_chain_error", "… and learned as a whole", "as a whole, {n} samples", 2)
        panel.legend(fontsize=6.5)
    canvas.legend(handles=error.lines, loc="outside lower center", ncols=2)
    return canvas


def _lines(
    panel: "Axes", shown: Sequence[RunSetting], metric: str, title: str, label: str = CHAIN_LABEL, first: int = 0
) -> None:
    """Draw the median of a metric against the links, one line per setting, in the roles from `first` on."""
    for setting, role in zip(shown, style.SERIES[first:], strict=False):
        model = setting.title("optimiser" if setting.card["model"] == "lagrangian" else "model")
        text = label.format(model=model, noise=f"{setting.card['tau_noise']:g}", n=setting.card["n_train"])
        panel.plot(*zip(*_along(setting, metric), strict=True), label=text, **role.marked_line_style)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_title(title)
    panel.set_xlabel("links")


def _along(setting: RunSetting, name: str) -> list[tuple[int, float]]:
    """The median of a metric at each number of links where it was measured."""
    measured = [(n, setting.values(f"{name}_{n}")) for n in LINKS]
    return [(n, float(np.median(values))) for n, values in measured if values.size]


def _samples(setting: RunSetting) -> int:
    return int(setting.card["n_train"])


FIGURES = (
    Figure(
        "composition",
        "A double pendulum of trained sub-models, and from scratch",
        "Noise of 0.1 N on every force; the cart with its rod was trained on 80,000 samples of its own with the same "
        "noise and is frozen. Lines are medians, dots members. Beside a full basis the trained part adds nothing, "
        "as it lies in the basis.",
        "Errors over the number of samples, both logarithmic, one line per way of building the model.",
        draw_samples,
    ),
    Figure(
        "chains",
        "Chains of a link that was learned once",
        "Relative error of all extensions and momenta against the true chain, and the cost of building and simulating"
        " it. In the middle, beside chains whose every force may depend on every link: least squares from as many "
        "samples of the whole chain, with the same noise.",
        "State error, and processor time, over the number of links, all logarithmic, one line per model.",
        draw_chains,
    ),
)
