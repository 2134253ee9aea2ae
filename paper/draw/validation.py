"""The counterpart of the paper's Fig. 4: the first 300 test points, plant against model, in several members."""

from typing import TYPE_CHECKING, Any

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, legend, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.report.writing import number
from repro.results.results import Results
from repro.results.selectors import NotRunError, one_setting

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "sip_regimes"
WHERE = {
    "model": "lagrangian",
    "basis": "t2",
    "hidden": "10",
    "objective": "inverse",
    "optimiser": "adam",
    "regime": "episodes",
    "episode_steps": 1000,
    "labels": "exact",
    "tau_noise": 0.0,
}
MEMBERS = 3
VELOCITIES = {"xd": ("cart velocity [m/s]", 0.05), "thetad": ("angular velocity [rad/s]", 0.12)}
SIGNALS = {
    "plant": ("plant", style.PLANT),
    "euler": ("model, one explicit Euler step", style.MODEL),
    "model": ("model, rollout", style.ROLLOUT),
}


def draw(results: Results) -> "Canvas | None":
    """Draw one column per member and one row per velocity; None without trajectories."""
    try:
        setting = one_setting(results, EXPERIMENT, WHERE)
    except NotRunError:
        return None
    signals = results.trajectories[results.trajectories["run"].isin(setting.runs)]
    members = [(run, seed) for seed, (run, _) in setting.members.items()]
    drawn = [entry for entry in members if len(_signal(signals, entry, "plant.xd"))][:MEMBERS]
    if not drawn:
        return None
    canvas = new_canvas(TEXT_WIDTH, 4.2)
    panels = canvas.subplots(len(VELOCITIES), len(drawn), sharex=True, squeeze=False)
    for row, (velocity, (label, printed)) in enumerate(VELOCITIES.items()):
        for column, entry in enumerate(drawn):
            panel = panels[row, column]
            errors = _lines(panel, signals, entry, velocity)
            parts = [f"{name} {number(error)}" for name, error in errors.items()]
            panel.set_title("MAE: " + ", ".join(parts), fontsize=7.5, fontweight="normal")
            if column == 0:
                panel.set_ylabel(f"{label}\n(paper: MAE {printed})")
            if row == len(VELOCITIES) - 1:
                panel.set_xlabel(f"time [s], seed {entry[1]}")
    legend(canvas, panels[0, 0], {}, lines=dict(SIGNALS.values()))
    return canvas


def _lines(panel: Any, signals: "pd.DataFrame", entry: tuple[str, int], velocity: str) -> dict[str, float]:
    plant = _signal(signals, entry, f"plant.{velocity}")
    errors = {}
    for source, (_, role) in SIGNALS.items():
        line = _signal(signals, entry, f"{source}.{velocity}")
        if line.empty:
            continue
        panel.plot(line["t"], line["value"], linewidth=2.2 if source == "plant" else 1.2, **role.line_style)
        if source != "plant" and len(line) == len(plant):
            name = "one step" if source == "euler" else "rollout"
            errors[name] = float(np.mean(np.abs(line["value"].to_numpy() - plant["value"].to_numpy())))
    # A rollout that runs away must not flatten the plant.
    low, high = plant["value"].min(), plant["value"].max()
    room = 0.25 * max(high - low, 1e-9)
    panel.set_ylim(low - room, high + room)
    return errors


def _signal(signals: "pd.DataFrame", entry: tuple[str, int], name: str) -> "pd.DataFrame":
    run, member = entry
    chosen = (signals["run"] == run) & (signals["member"] == member) & (signals["name"] == name)
    return signals[chosen].sort_values("t")


FIGURES = (
    Figure(
        "validation",
        "Plant against model on the test set (Fig. 4)",
        "The first 300 test points of the PLNN on T2/V1 (1x10, Adam), in three members. The paper prints a mean "
        "absolute error of 0.05 m/s and 0.12 rad/s and does not say whether one step or a rollout is shown: both are.",
        "Two velocities over 300 steps for three members: the plant's line, one-step predictions on it, and rollouts "
        "that leave it.",
        draw,
    ),
)
