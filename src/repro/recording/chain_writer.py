"""The recording of a chain in motion: its masses on a line, plant and model one above the other, and their energies."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from repro.recording import palette
from repro.recording.chart import Chart, linked_time_axis
from repro.recording.contents import PLANT, Recording, part
from repro.recording.layout import CARD
from repro.recording.writer import write_whole

ROOT = "chain"
GAP = 3.0  # m between the two chains in the picture
MASS = 0.12  # m, radius of a mass in the picture


@dataclass(frozen=True)
class ChainMotion:
    """One chain: places (steps, links) of its masses along the line in m, the wall at 0; energy (steps,) in J."""

    places: np.ndarray
    energy: np.ndarray


@dataclass(frozen=True)
class ChainRecording(Recording):
    """The true chain, and label -> learned chain."""

    plant: ChainMotion
    models: Mapping[str, ChainMotion]


def write_chain_recording(path: Path, recording: ChainRecording) -> None:
    """Write a whole .rrd file or none. Raises OSError when it could not be written completely."""
    chains = {PLANT: recording.plant, **recording.models}
    colours = {**palette.colours(recording.models), PLANT: palette.PLANT}
    energies = {label: chain.energy for label, chain in chains.items()}
    chart = Chart("energy/H", "Energy H", "H", "J", energies, colours, reference=PLANT)
    motion = rrb.Spatial2DView(origin=f"/{ROOT}", name="Motion [m]")
    charts = rrb.Tabs(chart.view(), linked_time_axis(recording.time))
    card = rrb.TextDocumentView(origin=CARD)
    panels = rrb.Horizontal(rrb.Vertical(motion, charts), card, column_shares=[3, 1])
    window = rrb.Blueprint(panels, collapse_panels=True)

    def draw(stream: rr.RecordingStream, time: rr.TimeColumn) -> None:
        for row, (label, chain) in enumerate(chains.items()):
            points = np.stack([chain.places, np.full_like(chain.places, row * GAP)], axis=-1).astype(np.float32)
            wall = np.tile(np.array([0.0, row * GAP], dtype=np.float32), (len(points), 1, 1))
            masses, springs = (f"{ROOT}/{part(label)}/{shape}" for shape in ("masses", "springs"))
            stream.log(masses, rr.Points2D.from_fields(radii=MASS, colors=colours[label]), static=True)
            stream.log(springs, rr.LineStrips2D.from_fields(radii=MASS / 4, colors=colours[label]), static=True)
            places = rr.Points2D.columns(positions=points.reshape(-1, 2)).partition([points.shape[1]] * len(points))
            stream.send_columns(masses, [time], places)
            strips = rr.LineStrips2D.columns(strips=list(np.concatenate([wall, points], axis=1)))
            stream.send_columns(springs, [time], strips)

    write_whole(path, recording, window, [chart], draw)
