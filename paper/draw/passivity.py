"""Passivity: the worst margin while a fit goes on, and the energy over long free motion."""

import json
from typing import TYPE_CHECKING

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import settings, with_varying_options

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

Lines = dict[str, tuple[np.ndarray, np.ndarray]]
EXPERIMENT = "ph_passivity"
FLOOR = 1e-17  # margins this close to zero are drawn here
BOUND = 1e-9
LEAST_ERROR, MOST_ERROR = 1e-10, 1e4  # J; beyond the second a model has long diverged


def draw_margins(results: Results) -> "Canvas | None":
    """Draw one line per setting: the worst margin over states and members at each step."""
    lines = [(setting, _worst(results, setting)) for setting in _watched(results)]
    lines = [(setting, line) for setting, line in lines if len(line)]
    if not lines:
        return None
    canvas = new_canvas(TEXT_WIDTH, 3.4)
    panel = canvas.subplots()
    for number, (setting, line) in enumerate(lines):
        role = style.SERIES[number % len(style.SERIES)]
        panel.plot(line.index, line, label=_label(setting), **role.line_style)
    panel.axhline(BOUND, label="tolerance: 1e-9", **style.PAPER.line_style)
    panel.set_yscale("symlog", linthresh=1e-12)
    panel.set_yticks([-1e-2, -1e-6, -1e-10, 0, 1e-10, 1e-6, 1e-2, 1])
    panel.set_xscale("symlog", linthresh=10)
    panel.set_xlim(left=0)
    panel.set_xlabel("step of the optimiser")
    panel.set_ylabel("worst passivity margin")
    canvas.legend(loc="outside lower center", ncols=2)
    return canvas


def draw_energy(results: Results) -> "Canvas | None":
    """Draw the energy along free motion and its error for the first member of each setting, one row per plant."""
    stored = [(each, _energies(results, each)) for each in with_varying_options(settings(results, EXPERIMENT))]
    rows: dict[str, list[tuple[RunSetting, Lines]]] = {}
    for setting, lines in stored:
        if lines:
            rows.setdefault(_plant(setting), []).append((setting, lines))
    if not rows:
        return None
    canvas = new_canvas(TEXT_WIDTH, 3.4 * len(rows))
    parts = canvas.subfigures(len(rows), 1, squeeze=False).ravel()
    for part, (plant, models) in zip(parts, rows.items(), strict=True):
        energy, error = part.subplots(1, 2)
        _draw_plant(energy, models[0][1])
        for number, (setting, lines) in enumerate(models):
            role = style.SERIES[1 + number % (len(style.SERIES) - 1)]
            time, model = lines["free.model.H"]
            energy.plot(time, model, label=_label(setting), **role.line_style)
            gap = np.abs(model - lines["free.plant.H"][1])
            error.plot(time, np.where(gap > 0, gap, np.nan), **role.line_style)
        error.set_yscale("log")
        error.set_ylim(max(error.get_ylim()[0], LEAST_ERROR), min(error.get_ylim()[1], MOST_ERROR))
        for panel, title in ((energy, f"H [J], {plant}"), (error, "error of H [J]")):
            panel.set_title(title)
            panel.set_xlabel("t [s]")
        part.legend(handles=energy.lines, loc="outside lower center", ncols=2)
    return canvas


def _draw_plant(panel: "Axes", lines: Lines) -> None:
    """The plant's energy, and axes that show it; a model that leaves them has diverged."""
    time, plant = lines["free.plant.H"]
    panel.plot(time, plant, label="plant", **style.PLANT.line_style)
    reach = max(0.5, 0.5 * float(np.ptp(plant)))
    panel.set_ylim(plant.min() - reach, plant.max() + reach)


def _plant(setting: RunSetting) -> str:
    return "with friction" if any(json.loads(setting.card["damping"] or "[]")) else "without friction"


def _watched(results: Results) -> list[RunSetting]:
    found = with_varying_options(settings(results, EXPERIMENT))
    return [each for each in found if each.values("passivity_margin_worst").size]


def _worst(results: Results, setting: RunSetting) -> "pd.Series[float]":
    """The largest margin of all members, by step."""
    curves = results.curves
    own = curves[curves["run"].isin(setting.runs) & (curves["name"] == "passivity_margin")]
    worst = own.groupby("step")["value"].max().sort_index()
    return worst.mask(worst.abs() < FLOOR, 0.0)


def _energies(results: Results, setting: RunSetting) -> Lines:
    rows = results.trajectories
    seed, (run, _) = next(iter(setting.members.items()))
    own = rows[(rows["run"] == run) & (rows["member"] == seed) & rows["name"].str.startswith("free.")]
    return {
        str(name): (group["t"].to_numpy(dtype=float), group["value"].to_numpy(dtype=float))
        for name, group in own.sort_values("t").groupby("name")
    }


def _label(setting: RunSetting) -> str:
    options = setting.card["options"].replace("_", " ")
    usual = setting.card["optimiser"] == "levenberg_marquardt"
    parts = [setting.title("model", "basis"), options, "" if usual else setting.title("optimiser")]
    return ", ".join(part for part in parts if part)


FIGURES = (
    Figure(
        "passivity_margin",
        "Passivity while training",
        "The largest (dH/dt - y'u) / (|y'u| + |grad H| |xdot|) over 128 random states and all members at each step of"
        " the optimiser; above zero energy is made. A model without an energy of its own is judged by the plant's. By"
        " Levenberg-Marquardt where no optimiser is named.",
        "Worst passivity margin over the steps of the optimiser, one line per model, with zero marked.",
        draw_margins,
    ),
    Figure(
        "energy_over_time",
        "Energy over long free motion",
        "The plant's energy along the motion of the plant and of each model, from the same start, without input: "
        "first member, first start. Models with energies are followed by the discrete gradient, the black box by RK4."
        " By Levenberg-Marquardt where no optimiser is named.",
        "One panel per model: energy over time of the plant and of the model along the same motion.",
        draw_energy,
    ),
)
