"""Passivity: the worst margin while a fit goes on, and the energy over long free motion."""

from typing import TYPE_CHECKING

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.results import Results
from repro.report.selection import settings
from repro.report.setting import Setting
from repro.report.style import TEXT_WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "ph_passivity"
FLOOR = 1e-17  # margins this close to zero are drawn here
BOUND = 1e-9


def draw_margins(results: Results) -> "Canvas | None":
    """Draw one line a setting: the worst margin over states and members at each step, on a log scale of both signs."""
    lines = [(setting, _worst(results, setting)) for setting in _watched(results)]
    lines = [(setting, line) for setting, line in lines if line.size]
    if not lines:
        return None
    canvas = new_canvas(TEXT_WIDTH, 3.4)
    panel = canvas.subplots()
    for number, (setting, line) in enumerate(lines):
        role = style.SERIES[number % len(style.SERIES)]
        panel.plot(np.arange(line.size), line, label=_label(setting), **role.line_style)
    panel.axhline(BOUND, label="asked: never above 1e-9", **style.PAPER.line_style)
    panel.set_yscale("symlog", linthresh=1e-12)
    panel.set_xscale("symlog", linthresh=10)
    panel.set_xlabel("step of the optimiser")
    panel.set_ylabel("worst passivity margin")
    canvas.legend(loc="outside lower center", ncols=2)
    return canvas


def draw_energy(results: Results) -> "Canvas | None":
    """Draw the plant's energy along the plant's and the models' free motion, a panel a setting, first members."""
    found = [(setting, _energies(results, setting)) for setting in settings(results, EXPERIMENT)]
    found = [(setting, lines) for setting, lines in found if lines]
    if not found:
        return None
    canvas = new_canvas(TEXT_WIDTH, 1.7 * ((len(found) + 1) // 2))
    panels = canvas.subplots((len(found) + 1) // 2, 2, sharex=True, squeeze=False).ravel()
    drawn = {}
    for panel, (setting, lines) in zip(panels, found, strict=False):
        for name, role in (("plant", style.PLANT), ("model", style.MODEL)):
            time, energy = lines[f"free.{name}.H"]
            drawn[name] = panel.plot(time, energy, label=name, **role.line_style)[0]
        plant = lines["free.plant.H"][1]
        reach = max(0.5, 2 * float(np.ptp(plant)))
        panel.set_ylim(plant.min() - reach, plant.max() + reach)
        panel.set_title(_label(setting))
        panel.set_ylabel("H [J]")
    for panel in panels[len(found) :]:
        panel.set_visible(False)
    for panel in panels[-2:]:
        panel.set_xlabel("t [s]")
    canvas.legend(handles=[*drawn.values()], loc="outside upper left", ncols=2)
    return canvas


def _watched(results: Results) -> list[Setting]:
    return [s for s in settings(results, EXPERIMENT) if s.values("passivity_margin_worst").size]


def _worst(results: Results, setting: Setting) -> np.ndarray:
    curves = results.curves
    own = curves[curves["run"].isin(setting.run_ids) & (curves["name"] == "passivity_margin")]
    worst = own.groupby("step")["value"].max().sort_index().to_numpy(dtype=float)
    return np.where(np.abs(worst) < FLOOR, 0.0, worst)


def _energies(results: Results, setting: Setting) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    rows = results.trajectories
    seed, (run, _) = next(iter(setting.members.items()))
    own = rows[(rows["run"] == run) & (rows["member"] == seed) & rows["name"].str.startswith("free.")]
    return {
        str(name): (group["t"].to_numpy(dtype=float), group["value"].to_numpy(dtype=float))
        for name, group in own.sort_values("t").groupby("name")
    }


def _label(setting: Setting) -> str:
    options = (setting.card["options"] or "").replace("_", " ").replace(", starts=3", "").removesuffix("starts=3")
    damped = "damped" if setting.card["damping"] not in ("[]", "", None, []) else ""
    parts = [setting.title("model", "optimiser"), options.strip(", "), damped]
    return ", ".join(part for part in parts if part)


MARGINS = Figure(
    "passivity_margin",
    "Passivity while training",
    "The largest (dH/dt - y'u) / (|y'u| + |grad H| |xdot|) over 128 random states and all members at each step of the "
    "optimiser; above zero energy is made. A model without an energy of its own is judged by the plant's.",
    draw_margins,
)
ENERGY = Figure(
    "energy_over_time",
    "Energy over long free motion",
    "The plant's energy along the motion of the plant and of each model, from the same start, without input: first "
    "member, first start. Port-Hamiltonian models are followed by the discrete gradient, all others by RK4.",
    draw_energy,
)
