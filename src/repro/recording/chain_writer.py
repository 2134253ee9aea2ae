"""The recording of a chain in motion: its masses on a line, plant and model one above the other, and their energies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from repro.recording import palette
from repro.recording.card_page import card_page
from repro.recording.chart import Chart, part
from repro.recording.contents import PLANT
from repro.recording.layout import CARD, TIMELINE
from repro.recording.writer import APPLICATION, read_recording
from repro.tracking.files import replacing

ROOT = "chain"
GAP = 3.0  # m between the two chains in the picture
MASS = 0.12  # m, radius of a mass in the picture


@dataclass(frozen=True)
class ChainMotion:
    """One chain: places (steps, links) of its masses along the line in m, the wall at 0; energy (steps,) in J."""

    places: np.ndarray
    energy: np.ndarray


@dataclass(frozen=True)
class ChainRecording:
    """What the recording shows: time (steps,) in s, the true chain, and label -> learned chain."""

    run: str
    title: str
    card: Mapping[str, object]
    time: np.ndarray
    plant: ChainMotion
    models: Mapping[str, ChainMotion]


def write_chain_recording(path: Path, recording: ChainRecording) -> None:
    """Write the .rrd aside, read it back, rename. Raises OSError when it could not be written completely."""
    chart = _energies(recording)
    with replacing(path) as temporary:
        _write(temporary, recording, chart)
        if len(read_recording(temporary)[chart.path].at) != len(recording.time):
            raise OSError("the recording was not written completely: rows are missing")


def _write(path: Path, recording: ChainRecording, chart: Chart) -> None:
    import rerun as rr
    import rerun.blueprint as rrb

    motion = rrb.Spatial2DView(origin=f"/{ROOT}", name="Motion [m]")
    window = rrb.Blueprint(
        rrb.Horizontal(rrb.Vertical(motion, chart.view()), rrb.TextDocumentView(origin=CARD), column_shares=[3, 1]),
        collapse_panels=True,
    )
    stream = rr.RecordingStream(APPLICATION, recording_id=recording.run)
    stream.save(path, default_blueprint=window)
    stream.send_recording_name(recording.title)
    text = card_page(recording.title, recording.card)
    stream.log(CARD, rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN), static=True)
    time = rr.TimeColumn(TIMELINE, duration=np.rint(recording.time * 1e9).astype("timedelta64[ns]"))
    chart.log(stream, time)
    chains = {PLANT: recording.plant, **recording.models}
    colours = {**palette.colours(recording.models), PLANT: palette.PLANT}
    for row, (label, chain) in enumerate(chains.items()):
        points = np.stack([chain.places, np.full_like(chain.places, row * GAP)], axis=-1).astype(np.float32)
        wall = np.tile(np.array([0.0, row * GAP], dtype=np.float32), (len(points), 1, 1))
        entity = f"{ROOT}/{part(label)}"
        stream.log(f"{entity}/masses", rr.Points2D.from_fields(radii=MASS, colors=colours[label]), static=True)
        stream.log(f"{entity}/springs", rr.LineStrips2D.from_fields(radii=MASS / 4, colors=colours[label]), static=True)
        masses = rr.Points2D.columns(positions=points.reshape(-1, 2)).partition([points.shape[1]] * len(points))
        stream.send_columns(f"{entity}/masses", [time], masses)
        strips = rr.LineStrips2D.columns(strips=list(np.concatenate([wall, points], axis=1)))
        stream.send_columns(f"{entity}/springs", [time], strips)
    stream.disconnect()


def _energies(recording: ChainRecording) -> Chart:
    chains = {PLANT: recording.plant, **recording.models}
    colours = {**palette.colours(recording.models), PLANT: palette.PLANT}
    lines = {label: chain.energy for label, chain in chains.items()}
    return Chart("energy/H", "Energy H", "H", "J", lines, colours, reference=PLANT)
