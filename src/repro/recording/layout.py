"""The charts of a recording, and the window that it opens to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

import numpy as np
import rerun.blueprint as rrb

from repro.recording import palette, scene
from repro.recording.chart import Chart, linked_time_axis
from repro.recording.contents import PLANT, RunRecording, part

CARD = "run_card"
TIMELINE = "sim_time"
LEARNING_TIMELINE = "fit_step"
BAND = 2  # standard errors that are drawn on either side of a motion


@dataclass(frozen=True)
class Layout:
    """The charts by their place in the window; a place may be empty."""

    coordinates: Sequence[Chart]
    rates: Sequence[Chart]
    energies: Sequence[Chart]
    inputs: Sequence[Chart]
    learning: Sequence[Chart]
    further: Sequence[Chart]

    @property
    def simulated(self) -> list[Chart]:
        """All charts over simulated time."""
        return [*self.coordinates, *self.rates, *self.inputs, *self.energies, *self.further]


def layout_of(recording: RunRecording) -> Layout:
    """The charts of a recording: plant against models in the same colours everywhere."""
    rollouts = {PLANT: recording.plant, **recording.models}
    members = [*recording.models, *(label for curve in recording.curves.values() for label in curve.values)]
    colours = {**palette.colours(members), PLANT: palette.PLANT}

    def compare(path: str, title: str, quantity: str, unit: str, lines: Mapping[str, np.ndarray]) -> Chart:
        return Chart(path, title, quantity, unit, lines, colours, reference=PLANT)

    def column(number: int) -> dict[str, np.ndarray]:
        lines = {label: rollout.state[:, number] for label, rollout in rollouts.items()}
        edges = {}
        for label, rollout in rollouts.items():
            if rollout.spread is not None:
                for sign, size in (("+", BAND), ("-", -BAND)):
                    edges[f"{label} {sign} {BAND} s.e."] = lines[label] + size * rollout.spread[:, number]
        colours.update(dict.fromkeys(edges, palette.BAND))
        return edges | lines  # later lines are drawn on top: a narrow band hides nothing

    coordinates, rates = [], []
    for number, (name, unit) in enumerate(recording.coordinates):
        symbol, rate = _symbol(name), f"d{_symbol(name)}/dt"
        rate_values = column(number + len(recording.coordinates))
        coordinates.append(compare(f"state/{part(name)}", symbol, symbol, unit, column(number)))
        rates.append(compare(f"state/{part(name)}d", rate, rate, f"{unit}/s", rate_values))
    energies = []
    for name in recording.plant.energies:
        lines = {label: rollout.energies[name] for label, rollout in rollouts.items()}
        energies.append(compare(f"energy/{part(name)}", f"Energy {name}", name, "J", lines))
    balance = palette.colours(recording.power, palette.QUANTITIES)
    first = next(iter(recording.power), "")
    inputs = [
        *_forces(recording),
        Chart("power", "Power balance of the plant", "", "W", recording.power, balance, reference=first),
    ]
    learning = [
        Chart(f"learning/{part(name)}", name, "", "", curve.values, colours) for name, curve in recording.curves.items()
    ]
    further = []
    for (name, (unit, values)), colour in zip(recording.charts.items(), cycle(palette.MODELS), strict=False):
        title, _, meaning = name.partition(": ")
        line = meaning or title
        path = f"further/{part(title)}"
        further.append(Chart(path, title, "", unit, {line: values}, {line: colour}, legend=bool(meaning)))
    return Layout(
        coordinates=_one_legend(coordinates),
        rates=_one_legend(rates),
        energies=_one_legend(energies),
        inputs=[chart for chart in inputs if chart.lines],
        learning=_one_legend(learning),
        further=further,
    )


def blueprint(layout: Layout, frame: scene.Frame, time: np.ndarray) -> rrb.Blueprint:
    """Scene and run card on the left, motion over `time` (steps,) in the middle, energies on the right; no panels."""
    pages: list[rrb.View | rrb.Container] = [rrb.TextDocumentView(origin=f"/{CARD}", name="Run card")]
    if layout.learning:
        name = f"Learning curves (choose timeline {LEARNING_TIMELINE} below)"
        pages.append(rrb.Horizontal(*(chart.view(linked=False) for chart in layout.learning), name=name))
    if layout.further:
        # Side by side: each of four in a stack would be too low for its time axis.
        columns = 1 if len(layout.further) < 4 else 2
        pages.insert(0, rrb.Grid(*(chart.view() for chart in layout.further), grid_columns=columns, name="Controller"))
    left = rrb.Vertical(scene.view(frame), rrb.Tabs(*pages, active_tab=0), row_shares=[5, 4])
    energies = _stack(layout.energies, "Energies")
    if layout.coordinates:
        states = _stack(layout.coordinates, "Coordinates"), _stack(layout.rates, "Rates")
        motion = rrb.Tabs(*states, linked_time_axis(time), active_tab=0)
        shares = [len(layout.coordinates), *(1 for _ in layout.inputs)]
        middle = rrb.Vertical(motion, *(chart.view() for chart in layout.inputs), row_shares=shares)
        panels = rrb.Horizontal(left, middle, energies, column_shares=[5, 4, 4])
    else:
        panels = rrb.Horizontal(left, rrb.Tabs(energies, linked_time_axis(time), active_tab=0))
    return rrb.Blueprint(
        panels,
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="playing", loop_mode="all"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
        auto_layout=False,
    )


def _stack(charts: Sequence[Chart], name: str) -> rrb.Vertical:
    return rrb.Vertical(*(chart.view() for chart in charts), name=name)


def _one_legend(charts: Sequence[Chart]) -> list[Chart]:
    """The same lines in the same colours need one legend, at the top."""
    return [replace(chart, legend=number == 0) for number, chart in enumerate(charts)]


def _forces(recording: RunRecording) -> list[Chart]:
    """One chart of the forces, in N, and one of the torques, in N m, where the inputs have any."""
    charts = []
    units = dict(recording.coordinates)
    for quantity, unit, along in (("force", "N", "m"), ("torque", "N m", "rad")):
        values = {name: force for name, force in recording.forces.items() if units[name] == along}
        lines = {_symbol(name) if len(values) > 1 else "": force for name, force in values.items()}
        colours = palette.colours(lines, (palette.FORCE, *palette.MODELS))
        if lines:
            charts.append(Chart(quantity, quantity.title(), quantity, unit, lines, colours, legend=len(lines) > 1))
    return charts


def _symbol(name: str) -> str:
    return name.replace("theta", "θ")
