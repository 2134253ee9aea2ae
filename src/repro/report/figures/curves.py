"""Learning curves: members as thin lines, their median thick."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from repro.report.figures.figure import Canvas, legend, small_multiples
from repro.report.style import Role
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import anchor_name
from repro.tracking.lazy_pandas import pd

COLUMNS = 3
TITLE = 22  # characters above one of three panels


@dataclass(frozen=True)
class Quantity:
    """A recorded quantity: its name in the curves, its label, and below which size it is drawn in proportion."""

    name: str
    label: str
    small: float | None = None


LOSS = Quantity("loss", "loss")


def curve_panels(
    results: Results,
    panels: Mapping[str, Sequence[tuple[str, RunSetting]]],
    roles: Mapping[str, Role],
    quantity: Quantity = LOSS,
) -> Canvas | None:
    """Draw one panel per title, with a named line per setting; None without panels."""
    if not panels:
        return None
    columns = min(COLUMNS, len(panels))
    canvas, axes = small_multiples(len(panels), columns, 2.1, 0.6, share_y=True)
    for place, (axis, (title, lines)) in enumerate(zip(axes, panels.items(), strict=True)):
        axis.set_title(_in_two_lines(title))
        for name, setting in lines:
            table, role = _curve(results, setting, quantity), roles[name]
            for column in table:
                axis.plot(table.index, table[column], linewidth=0.5, alpha=0.45, color=role.colour)
            # Failed members are nan: in the median they count as infinitely wrong, and the line ends where most failed.
            median = table.fillna(np.inf).median(axis=1).replace(np.inf, np.nan)
            axis.plot(median.index, median, linewidth=1.8, **role.line_style)
        axis.set_xscale("symlog", linthresh=1)
        if quantity.small is None:
            axis.set_yscale("log")
        else:
            axis.set_yscale("symlog", linthresh=quantity.small)
            axis.axhline(0.0, color="0.4", linewidth=0.8, zorder=0)
        axis.set_xlabel("epoch or iteration")
        if place % columns == 0:
            axis.set_ylabel(quantity.label)
    legend(canvas, axes[0], {}, lines=roles, columns=4)
    return canvas


def with_curves(results: Results, candidates: Sequence[RunSetting], quantity: Quantity = LOSS) -> list[RunSetting]:
    """Keep the settings whose curve of a quantity was stored; anchors fall out."""
    return [s for s in candidates if anchor_name(s) is None and not _curve(results, s, quantity).empty]


def _curve(results: Results, setting: RunSetting, quantity: Quantity) -> "pd.DataFrame":
    chosen = results.curves[results.curves["run"].isin(setting.runs) & (results.curves["name"] == quantity.name)]
    members = {(run, seed) for seed, (run, _) in setting.members.items()}
    table = chosen.pivot_table(index="step", columns=["run", "member"], values="value", dropna=False)
    drawn = table.where(table > 0) if quantity.small is None else table
    return drawn[[key for key in drawn.columns if key in members]]


def _in_two_lines(title: str) -> str:
    """Break a long title in the middle of its parts, so that it stays above its own panel."""
    if len(title) <= TITLE or "\n" in title:
        return title
    parts = title.split(", ")
    half = -(-len(parts) // 2)
    return ", ".join(parts[:half]) + "\n" + ", ".join(parts[half:])
