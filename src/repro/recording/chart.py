"""A chart of a recording: some lines over one timeline, logged as columns and shown in one view."""

from collections.abc import Mapping
from dataclasses import dataclass
from uuid import UUID

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from repro.recording.palette import Colour

REFERENCE_WIDTH, WIDTH = 3.0, 1.6
# How far a view opens beyond the range of the reference, as a part of that range.
MOST_BEYOND = 0.6
PADDING = 0.06
# How far the time axes open beyond the motion, as parts of it: to the right there is room for the label of its end.
BEFORE, BEYOND = 0.02, 0.06
# The viewer keeps the range of all linked time axes under the id of a view that it never shows.
LINKED_AXES = UUID("5c0dca6a-e63f-9cf7-f657-2602590474cc")


@dataclass(frozen=True)
class Chart:
    """Lines of one quantity."""

    path: str  # entity that holds one vector of all lines at each time
    title: str  # of the view, without the unit
    quantity: str  # what every line is, e.g. "H"; "" where the labels name it
    unit: str  # "" for a number without one
    lines: Mapping[str, np.ndarray]  # label -> (steps,) values; a value that is not finite is a gap
    colours: Mapping[str, Colour]  # label -> colour
    reference: str = ""  # label of the line that others are compared with: thicker, and the view opens to its range
    legend: bool = True  # whether the view has one

    @property
    def names(self) -> list[str]:
        """Name of each line in the legend: quantity, label and unit."""
        return [with_unit(f"{self.quantity} {label}".strip(), self.unit) for label in self.lines]

    def log(self, recording: rr.RecordingStream, index: rr.TimeColumn) -> None:
        """Send all lines as one column of vectors on the index's timeline, and their style once."""
        style = rr.SeriesLines(
            names=self.names,
            colors=[self.colours[label] for label in self.lines],
            widths=[REFERENCE_WIDTH if label == self.reference else WIDTH for label in self.lines],
        )
        recording.log(self.path, style, static=True)
        values = np.stack(list(self.lines.values()), axis=-1)
        recording.send_columns(self.path, [index], rr.Scalars.columns(scalars=values))

    def view(self, *, linked: bool = True) -> rrb.TimeSeriesView:
        """The view of all lines, its legend in a fixed corner, its time axis linked to that of the other charts."""
        opening = self.opening_range()
        link = rrb.components.LinkAxis.LinkToGlobal if linked else rrb.components.LinkAxis.Independent
        return rrb.TimeSeriesView(
            origin=f"/{self.path}",
            name=with_unit(self.title, self.unit),
            plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.LeftTop, visible=self.legend),
            axis_x=rrb.TimeAxis(link=link),
            axis_y=None if opening is None else rrb.ScalarAxis(range=opening),
        )

    def opening_range(self) -> tuple[float, float] | None:
        """Lowest and highest value in view: all of the reference, not what diverges; None leaves it to the viewer."""
        if not self.reference:
            return None
        low, high = _range(self.lines[self.reference])
        lowest, highest = _range(np.concatenate(list(self.lines.values())))
        beyond = MOST_BEYOND * (high - low)
        low, high = max(lowest, low - beyond), min(highest, high + beyond)
        padding = max(PADDING * (high - low), 1e-3, 1e-3 * abs(high))
        return low - padding, high + padding


def linked_time_axis(time: np.ndarray) -> rrb.TimeSeriesView:
    """The range of every linked time axis, as a view that is not shown: all of the motion, time (steps,) in s."""
    length = time[-1] - time[0]
    ends = (time[0] - BEFORE * length, time[-1] + BEYOND * length)
    view_range = rr.TimeRange(*(rr.TimeRangeBoundary.absolute(seconds=float(end)) for end in ends))
    view = rrb.TimeSeriesView(origin="/", visible=False, axis_x=rrb.TimeAxis(view_range=view_range))
    view.id = LINKED_AXES
    return view


def with_unit(name: str, unit: str) -> str:
    """A name with its unit in brackets."""
    return f"{name} [{unit}]" if unit else name


def _range(values: np.ndarray) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return float(finite.min()), float(finite.max())
