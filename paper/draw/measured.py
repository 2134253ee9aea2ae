"""Learning from positions alone: the error beside the Cramer-Rao bound, and the band of a roll-out."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import Where, settings

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "measured"
POSITIONS: Where = {"system": "sip", "basis": "t1", "data.sample_step": 0.01, "data.encoder_zero": 0.0}
METHODS: Mapping[str, Where] = {
    "Savitzky-Golay, least squares": {"labels": "savitzky_golay"},
    "momentum balance": {"labels": "smoothed", "objective": "balance"},
    "path": {"labels": "smoothed", "objective": "path"},
}
TYPICAL_NOISE = 0.001  # m, rad
ANGLE, ERROR = "theta", "standard_error.theta"
BAND = 2.0  # standard errors


def draw(results: Results) -> "Canvas | None":
    """Draw one line per method over samples, and over noise; the bound is that of the path's Fisher information."""
    found = {name: settings(results, EXPERIMENT, {**POSITIONS, **where}) for name, where in METHODS.items()}
    noisy = {name: [s for s in group if s.settings.get("data.q_noise")] for name, group in found.items()}
    if not any(noisy.values()):
        return None
    canvas = new_canvas(TEXT_WIDTH, 2.8)
    samples, noise, motion = canvas.subplots(1, 3)
    noise.sharey(samples)
    most = max(_samples(setting) for group in noisy.values() for setting in group)
    for name, role in zip(METHODS, style.SERIES, strict=False):
        over_samples = [s for s in noisy[name] if _noise(s) == TYPICAL_NOISE]
        over_noise = [s for s in noisy[name] if _samples(s) == most]
        for panel, group, along in ((samples, over_samples, _samples), (noise, over_noise, _noise)):
            _line(panel, group, along, "mae_qdd", label=name, **role.marked_line_style)
            if name == "path":
                _line(panel, group, along, "bound_mae_qdd", label="Cramér-Rao bound", color="black", linestyle="--")
    for panel, text in ((samples, "samples"), (noise, "noise of positions [m, rad]")):
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_xlabel(text)
    counts = sorted({_samples(setting) for group in noisy.values() for setting in group})
    samples.set_xticks(counts, [f"{count:g}" for count in counts])
    samples.set_xticks([], minor=True)  # their labels would overlap, since the axis spans one decade
    samples.set_title("MAE q̈ [m/s², rad/s²]")
    _rollout(motion, results.trajectories)
    canvas.legend(handles=samples.lines, loc="outside lower center", ncols=4)
    return canvas


def _line(panel: Any, group: list[RunSetting], along: Callable[[RunSetting], float], metric: str, **looks: Any) -> None:
    points = sorted((along(s), float(np.median(values))) for s in group if (values := s.values(metric)).size)
    if points:
        panel.plot(*zip(*points, strict=True), **looks)


def _rollout(panel: Any, trajectories: "pd.DataFrame") -> None:
    """The error of the angle along the first episode that was not learned, by one model, and its band."""
    known = trajectories[trajectories["name"] == ERROR]
    if known.empty:
        panel.set_axis_off()
        return
    run, member = known.iloc[0][["run", "member"]]
    rows = trajectories[(trajectories["run"] == run) & (trajectories["member"] == member)]
    lines = rows.pivot(index="t", columns="name", values="value").sort_index()
    first = lines[lines["episode"] == lines["episode"].iloc[0]]
    band, error = BAND * first[ERROR], first[f"model.{ANGLE}"] - first[f"plant.{ANGLE}"]
    panel.fill_between(first.index, -band, band, color=style.SERIES[2].colour, alpha=0.3, linewidth=0)
    panel.plot(first.index, error, color=style.SERIES[2].colour)
    panel.set_title("roll-out: error of θ [rad]")
    panel.set_xlabel("time [s]")


def _samples(setting: RunSetting) -> float:
    return float(setting.card["n_train"])


def _noise(setting: RunSetting) -> float:
    return float(setting.settings["data.q_noise"])


FIGURES = (
    Figure(
        "measured",
        "Learning from positions alone",
        "Single pendulum, T1, positions at 100 Hz: medians over the members. The bound is the error that the Fisher "
        "information of the path fit predicts for any unbiased method. Right: how far one model, learned from the "
        "fewest samples, is off along a motion that it has not seen, and two standard errors on either side.",
        "Two panels with logarithmic axes: the error of accelerations against samples and against noise, one line per "
        "method, and the Cramér-Rao bound as a dashed line. A third one: the error of the angle in a roll-out over "
        "time, in a shaded band.",
        draw,
    ),
)
