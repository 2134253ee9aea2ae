"""Paired timings: how many times longer the other takes, by size; to the right of the line ours is faster."""

from textwrap import wrap
from typing import Any

import numpy as np

from repro.report import style
from repro.report.figures.figure import Canvas, Figure, legend, new_canvas
from repro.report.style import TEXT_WIDTH, Role
from repro.tracking.lazy_pandas import pd

ROW = 0.34  # inches
LABEL = 52  # characters of a line
COLUMNS = 4  # of the legend
GROWTH = ("coordinates", "members", "samples")  # benches of how a step grows: they have no contenders
NEVER = 1.6  # times the greatest finite ratio: where a rival is drawn that did not reach the accuracy


def draw_pairs(bench: "pd.DataFrame") -> Canvas | None:
    """Draw one row per pair of contenders and one marker per size, or accuracy; None without timings."""
    # A rival of unbounded time did not reach the accuracy; where ours did not, or neither, the table has it.
    bench = bench[(bench["ratio_median"] > 0) & ~bench["name"].isin(GROWTH)]
    if bench.empty:
        return None
    pairs = list(bench.groupby(["name", "ours", "other"], sort=False))
    sizes = list(dict.fromkeys(_size(row) for row in bench.to_dict("records")))
    roles = {size: style.SERIES[number % len(style.SERIES)] for number, size in enumerate(sizes)}
    finite = bench["ratio_median"][np.isfinite(bench["ratio_median"])]
    greatest = float(finite.max()) * NEVER if len(finite) else 10.0
    from matplotlib.ticker import LogLocator, NullFormatter

    canvas = new_canvas(TEXT_WIDTH, 0.9 + 0.2 * (-(-len(sizes) // COLUMNS)) + ROW * len(pairs))
    panel = canvas.subplots()
    for height, (_, rows) in enumerate(pairs):
        _row(panel, height, rows, roles, greatest)
    panel.axvline(1, linewidth=1.2, zorder=0.5, **style.PAPER.line_style)
    panel.set_xscale("log")
    panel.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    panel.xaxis.set_major_formatter("{x:g}")
    panel.xaxis.set_minor_formatter(NullFormatter())
    panel.set_yticks(range(len(pairs)), [_label(names) for names, _ in pairs], fontsize=6)
    panel.set_ylim(len(pairs) - 0.5, -0.5)
    panel.grid(visible=False, axis="y")
    never = " (right edge: never reached by the other)" if np.isinf(bench["ratio_median"]).any() else ""
    panel.set_xlabel(f"processor time, other / ours{never}")
    legend(canvas, panel, roles, columns=COLUMNS)
    return canvas


def _row(panel: Any, height: float, rows: "pd.DataFrame", roles: dict[str, Role], greatest: float) -> None:
    offsets = np.linspace(-0.25, 0.25, len(rows)) if len(rows) > 1 else np.zeros(1)
    for offset, row in zip(offsets, rows.to_dict("records"), strict=True):
        place, role = height + offset, roles[_size(row)]
        if not np.isfinite(row["ratio_median"]):
            panel.plot([greatest], [place], **{**role.marker_style, "marker": ">"})
            continue
        low, high = row["ratio_q25"], min(row["ratio_q75"], greatest)
        panel.plot([low, high], [place, place], color=role.colour, linewidth=1.0)
        panel.plot([row["ratio_median"]], [place], **role.marker_style)


def _label(names: Any) -> str:
    name, ours, other = names
    lines = (f"{name.replace('_', ' ')}: {ours}", f"against {other}")
    return "\n".join(part for line in lines for part in wrap(line, LABEL, break_on_hyphens=False))


def _size(row: Any) -> str:
    if row["metric"]:
        return f"{row['size']}, {row['metric']}" + ("" if np.isnan(row["goal"]) else f" {row['goal']:g}")
    members = int(row["members"])
    return str(row["size"]) if members == 1 else f"{row['size']}, {members} members"


TIMING = (
    Figure(
        "timing",
        "Paired timings of equal work",
        "Each marker is the median of paired, interleaved timings of one size, its line the quartiles; right of the "
        "dashed line ours is faster. What is timed, and how, stands in the table of timings.",
        "One row per comparison: ratio of times and its quartiles on a logarithmic axis; a dashed line at one.",
        lambda results: draw_pairs(results.bench[results.bench["metric"] == ""]),
    ),
    Figure(
        "timing_accuracy",
        "Paired timings to equal accuracy",
        "Each marker is the median over starts of the ratio of the times until an error falls to a share of the "
        "trivial one, its line the quartiles; right of the dashed line ours is faster.",
        "One row per pair of trainings: ratio of times on a logarithmic axis, one marker per accuracy; a dashed line "
        "at one.",
        lambda results: draw_pairs(results.bench[results.bench["metric"] != ""]),
    ),
)
