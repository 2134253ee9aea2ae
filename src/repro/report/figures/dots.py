"""Dot plots: one row per setting, one dot per member, a bar at the median; failed members are counted."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from repro.report import style
from repro.report.figures.figure import Canvas, legend, new_canvas
from repro.report.style import TEXT_WIDTH, Role
from repro.results.metric_names import metric_named
from repro.results.run_setting import RunSetting

Group = tuple[str, Sequence[tuple[RunSetting, Role]]]


def dot_plot(
    groups: Sequence[Group],
    metrics: Mapping[str, str],
    *,
    roles: Mapping[str, Role],
    printed: Mapping[str, float] | None = None,
    reference: Callable[[str], float | None] = lambda _metric: None,
) -> Canvas:
    """Draw groups of settings, one row per group; `metrics` maps each metric, one panel each, to its unit.

    `printed` gives the paper's value of a metric, `reference` that of the trivial model; both become vertical lines.
    """
    canvas = new_canvas(TEXT_WIDTH, 1.1 + 0.36 * len(groups) + 0.2 * (len(roles) > 2))
    panels = np.atleast_1d(canvas.subplots(1, len(metrics), sharey=True))
    for panel, (metric, unit) in zip(panels, metrics.items(), strict=True):
        for row, (_, members) in enumerate(groups):
            offsets = np.linspace(-0.2, 0.2, len(members)) if len(members) > 1 else (0.0,)
            for offset, (setting, role) in zip(offsets, members, strict=True):
                _dots(panel, row + offset, setting.values(metric), role)
                if setting.failed and panel is panels[-1]:
                    place = {"xycoords": ("axes fraction", "data"), "va": "center", "fontsize": 7}
                    text = f"{setting.failed} of {setting.n} failed"
                    panel.annotate(text, (1.02, row + offset), color=role.colour, **place)
        _line(panel, (printed or {}).get(metric), style.PAPER)
        _line(panel, reference(metric), style.ANCHOR)
        # A logarithmic axis of less than a decade has no readable ticks.
        low, high = panel.dataLim.intervalx
        panel.set_xscale("log" if low > 0 and high > 6 * low else "linear")
        panel.set_xlabel(f"{metric_named(metric).label} [{unit}]")
        panel.grid(visible=False, axis="y")
    panels[0].set_yticks(range(len(groups)), [title for title, _ in groups])
    panels[0].set_ylim(len(groups) - 0.5, -0.5)
    lines = {}
    if any(metric in (printed or {}) for metric in metrics):
        lines["printed in the paper"] = style.PAPER
    if any(reference(metric) is not None for metric in metrics):
        lines["trivial model"] = style.ANCHOR
    legend(canvas, panels[0], roles, lines=lines)
    return canvas


def _dots(panel: Any, height: float, values: np.ndarray, role: Role) -> None:
    finished = values[np.isfinite(values) & (values > 0)]
    panel.plot(finished, np.full(finished.size, height), alpha=0.6, **role.marker_style)
    if finished.size:
        median = [np.median(finished)] * 2
        ends = [height - 0.2, height + 0.2]
        panel.plot(median, ends, color="white", linewidth=4)
        panel.plot(median, ends, color=role.colour, linewidth=2.2)


def _line(panel: Any, value: float | None, role: Role) -> None:
    if value is not None and np.isfinite(value) and value > 0:
        panel.axvline(value, linewidth=1.2, zorder=0.5, **role.line_style)
