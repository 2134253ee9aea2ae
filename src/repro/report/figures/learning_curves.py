"""Learning curves: members as thin lines, their median thick."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.report import style
from repro.report.figures.figure import Figure, new_canvas
from repro.report.results import Results
from repro.report.selection import Where, anchor_name, settings
from repro.report.setting import Setting
from repro.report.style import TEXT_WIDTH, Role

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Canvas

# What both objectives are judged by; the loss only where this was not followed.
QUANTITIES = {"mae_tau": "MAE τ [N, N m]", "loss": "loss"}
COLUMNS = 3
TITLE = 22  # characters above one of three panels


def draw_objectives(results: Results) -> "Canvas | None":
    """Draw one panel a net and optimiser, inverse against forward."""
    found = _with_curves(results, settings(results, "sip_forward_inverse"))
    roles = {"inverse": style.INVERSE, "forward": style.FORWARD}
    panels: dict[str, list[tuple[str, Setting]]] = {}
    for setting in found:
        title = setting.title("basis", "hidden", "optimiser")
        panels.setdefault(title, []).append((str(setting.card["objective"]), setting))
    return curve_panels(results, panels, roles)


def draw_optimisers(results: Results) -> "Canvas | None":
    """Draw one panel with a line an optimiser, on the same net."""
    where: Where = {"model": "lagrangian", "basis": "t2", "hidden": "10", "objective": "inverse"}
    found = _with_curves(results, settings(results, "sip_optimisers", where))
    lines = [(_optimiser(setting), setting) for setting in found]
    names = list(dict.fromkeys(name for name, _ in lines))
    roles = {name: style.SERIES[index % len(style.SERIES)] for index, name in enumerate(names)}
    return curve_panels(results, {"T2/V1, 1x10, inverse": lines} if lines else {}, roles)


def curve_panels(
    results: Results, panels: Mapping[str, Sequence[tuple[str, Setting]]], roles: Mapping[str, Role]
) -> "Canvas | None":
    """Draw one panel a title, with a named line a setting; None without panels."""
    if not panels:
        return None
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    canvas = new_canvas(TEXT_WIDTH, 0.6 + 2.1 * rows)
    axes = canvas.subplots(rows, columns, squeeze=False, sharey=True).ravel()
    quantity = _common_quantity(results, [setting for lines in panels.values() for _, setting in lines])
    for place, (axis, (title, lines)) in enumerate(zip(axes, panels.items(), strict=False)):
        axis.set_title(_in_two_lines(title))
        for name, setting in lines:
            _curves(axis, _curve(results, setting, quantity), roles[name])
        axis.set_xscale("symlog", linthresh=1)
        axis.set_yscale("log")
        axis.set_xlabel("epoch or iteration")
        if place % columns == 0:
            axis.set_ylabel(QUANTITIES[quantity])
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


def _curve(results: Results, setting: Setting, name: str) -> "pd.DataFrame":
    chosen = results.curves[results.curves["run"].isin(setting.run_ids) & (results.curves["name"] == name)]
    members = {(run, seed) for seed, (run, _) in setting.members.items()}
    table = chosen.pivot_table(index="step", columns=["run", "member"], values="value", dropna=False)
    positive = table.where(table > 0)
    return positive[[key for key in positive.columns if key in members]]


def _common_quantity(results: Results, shown: Sequence[Setting]) -> str:
    followed = all(not _curve(results, setting, "mae_tau").empty for setting in shown)
    return "mae_tau" if followed else "loss"


def _with_curves(results: Results, found: Sequence[Setting]) -> list[Setting]:
    return [
        setting
        for setting in found
        if anchor_name(setting) is None and any(not _curve(results, setting, quantity).empty for quantity in QUANTITIES)
    ]


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
OPTIMISERS = Figure(
    "learning_curves_optimisers",
    "Learning curves: optimisers",
    "The paper's net (T2/V1, 1x10, inverse objective) under different optimisers. Thin lines are members.",
    draw_optimisers,
)
