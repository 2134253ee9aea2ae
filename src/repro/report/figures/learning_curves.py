"""Learning curves: members as thin lines, their median thick."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH, Role
from repro.results.results import Results
from repro.results.run_setting import Setting
from repro.results.selectors import Where, anchor_name, settings

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

COLUMNS = 3
TITLE = 22  # characters above one of three panels


@dataclass(frozen=True)
class Quantity:
    """What is followed: its name in the curves, its label, and below which size it is drawn in proportion."""

    name: str
    label: str
    small: float | None = None


LOSS = Quantity("loss", "loss")
INERTIA = Quantity("min_eig_M", "min eig M [kg, kg m²]", small=1e-3)


def draw_objectives(results: Results) -> "Canvas | None":
    """Draw one panel a net and optimiser, inverse against forward."""
    return _objectives(results, LOSS)


def draw_inertia(results: Results) -> "Canvas | None":
    """Draw the same panels, with the least eigenvalue of the mass matrix."""
    return _objectives(results, INERTIA)


def _objectives(results: Results, quantity: Quantity) -> "Canvas | None":
    found = _with_curves(results, settings(results, "sip_forward_inverse"), quantity)
    roles = {"inverse": style.INVERSE, "forward": style.FORWARD}
    panels: dict[str, list[tuple[str, Setting]]] = {}
    for setting in found:
        title = setting.title("basis", "hidden", "optimiser")
        panels.setdefault(title, []).append((str(setting.card["objective"]), setting))
    return curve_panels(results, panels, roles, quantity)


def draw_optimisers(results: Results) -> "Canvas | None":
    """Draw one panel with a line an optimiser, on the same net."""
    where: Where = {"model": "lagrangian", "basis": "t2", "hidden": "10", "objective": "inverse"}
    found = _with_curves(results, settings(results, "sip_optimisers", where))
    lines = [(_optimiser(setting), setting) for setting in found]
    names = list(dict.fromkeys(name for name, _ in lines))
    roles = {name: style.SERIES[index % len(style.SERIES)] for index, name in enumerate(names)}
    return curve_panels(results, {"T2/V1, 1x10, inverse": lines} if lines else {}, roles)


def curve_panels(
    results: Results,
    panels: Mapping[str, Sequence[tuple[str, Setting]]],
    roles: Mapping[str, Role],
    quantity: Quantity = LOSS,
) -> "Canvas | None":
    """Draw one panel a title, with a named line a setting; None without panels."""
    if not panels:
        return None
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    canvas = new_canvas(TEXT_WIDTH, 0.6 + 2.1 * rows)
    axes = canvas.subplots(rows, columns, squeeze=False, sharey=True).ravel()
    for place, (axis, (title, lines)) in enumerate(zip(axes, panels.items(), strict=False)):
        axis.set_title(_in_two_lines(title))
        for name, setting in lines:
            _curves(axis, _curve(results, setting, quantity), roles[name])
        axis.set_xscale("symlog", linthresh=1)
        if quantity.small is None:
            axis.set_yscale("log")
        else:
            axis.set_yscale("symlog", linthresh=quantity.small)
            axis.axhline(0.0, color="0.4", linewidth=0.8, zorder=0)
        axis.set_xlabel("epoch or iteration")
        if place % columns == 0:
            axis.set_ylabel(quantity.label)
    for axis in axes[len(panels) :]:
        axis.remove()
    handles = [axes[0].plot([], [], label=name, **role.line_style)[0] for name, role in roles.items()]
    canvas.legend(handles=handles, loc="outside upper left", ncols=min(len(handles), 4))
    return canvas


def _curves(axis: Any, table: "pd.DataFrame", role: Role) -> None:
    for column in table:
        axis.plot(table.index, table[column], linewidth=0.5, alpha=0.45, color=role.colour)
    # Failed members are nan: in the median they count as infinitely wrong, and the line ends where most have failed.
    median = table.fillna(np.inf).median(axis=1).replace(np.inf, np.nan)
    axis.plot(median.index, median, linewidth=1.8, **role.line_style)


def _curve(results: Results, setting: Setting, quantity: Quantity) -> "pd.DataFrame":
    chosen = results.curves[results.curves["run"].isin(setting.run_ids) & (results.curves["name"] == quantity.name)]
    members = {(run, seed) for seed, (run, _) in setting.members.items()}
    table = chosen.pivot_table(index="step", columns=["run", "member"], values="value", dropna=False)
    drawn = table.where(table > 0) if quantity.small is None else table
    return drawn[[key for key in drawn.columns if key in members]]


def _with_curves(results: Results, found: Sequence[Setting], quantity: Quantity = LOSS) -> list[Setting]:
    return [one for one in found if anchor_name(one) is None and not _curve(results, one, quantity).empty]


def _in_two_lines(title: str) -> str:
    """Break a long title in the middle of its parts, so that it stays above its own panel."""
    if len(title) <= TITLE or "\n" in title:
        return title
    parts = title.split(", ")
    half = -(-len(parts) // 2)
    return ", ".join(parts[:half]) + "\n" + ", ".join(parts[half:])


def _optimiser(setting: Setting) -> str:
    name = setting.title("optimiser")
    return f"{name}, curriculum" if setting.card["curriculum"] not in ("", "none", "false") else name


OBJECTIVES = Figure(
    "learning_curves_objectives",
    "Learning curves: inverse against forward",
    "Identical nets and budgets. Thin lines are members, the thick one their median; it ends where most have diverged.",
    draw_objectives,
)
INERTIAS = Figure(
    "learning_curves_inertia",
    "The mass matrix while learning: inverse against forward",
    "Least eigenvalue of the learned M over samples of the test set; where it crosses zero the model has no forward "
    "dynamics. Identical nets and budgets. Thin lines are members, the thick one their median.",
    draw_inertia,
)
OPTIMISERS = Figure(
    "learning_curves_optimisers",
    "Learning curves: optimisers",
    "The paper's net (T2/V1, 1x10, inverse objective) under different optimisers. Thin lines are members.",
    draw_optimisers,
)
