"""The recording of a run: one .rrd file that opens to a finished layout."""

import os
import warnings
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
from rerun.chunk import RrdReader
from rerun.error_utils import RerunWarning

from repro.errors import UserError
from repro.recording import scene
from repro.recording.contents import RunRecording
from repro.recording.layout import CARD, LEARNING_TIMELINE, TIMELINE, blueprint, layout_of
from repro.tracking.files import replacing
from repro.tracking.plain_data import Json, flattened

# The same for all recordings, so that the viewer shares settings between them.
APPLICATION = "repro"


@dataclass(frozen=True)
class Track:
    """One chart read back: `at` (rows,) on its timeline (s, or steps), `values` (rows, lines), the lines' `names`."""

    timeline: str
    at: np.ndarray
    values: np.ndarray
    names: tuple[str, ...]


def write_recording(path: Path, recording: RunRecording) -> None:
    """Write the .rrd aside, read it back, rename: one of this name is complete. OSError where it cannot be written."""
    layout = layout_of(recording)
    frame = scene.frame_of(recording.plant.shapes, recording.obstacle)
    with replacing(path) as temporary, warnings.catch_warnings():
        # The library only warns of arrays that do not fit.
        warnings.simplefilter("error", RerunWarning)
        stream = rr.RecordingStream(APPLICATION, recording_id=recording.run)
        stream.save(temporary, default_blueprint=blueprint(layout, frame, recording.time))
        stream.send_recording_name(recording.title)
        # a value that is absent has no type, and rerun holds every name to one type
        present = {key: value for key, value in flattened(recording.card).items() if value is not None}
        plain = (bool, int, float, str)
        entries: Json = {key: value if isinstance(value, plain) else str(value) for key, value in present.items()}
        stream.send_property("run", rr.AnyValues(**{"title": recording.title, **entries}))
        text = card_page(recording.title, recording.card)
        stream.log(CARD, rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN), static=True)
        time = rr.TimeColumn(TIMELINE, duration=np.rint(recording.time * 1e9).astype("timedelta64[ns]"))
        for chart in layout.simulated:
            chart.log(stream, time)
        for chart, curve in zip(layout.learning, recording.curves.values(), strict=True):
            chart.log(stream, rr.TimeColumn(LEARNING_TIMELINE, sequence=curve.step))
        scene.log_scene(stream, time, recording, frame)
        stream.disconnect()
        _check(temporary, {chart.path for chart in layout.simulated}, len(recording.time))


def read_recording(path: Path) -> dict[str, Track]:
    """The charts of a recording by entity, e.g. "energy/H"; raises UserError when the file is missing or damaged."""
    try:
        with warnings.catch_warnings():
            # The library only warns about a truncated file.
            warnings.simplefilter("error", RerunWarning)
            chunks = RrdReader(path).stream().to_chunks()
    except (RuntimeError, ValueError, OSError, RerunWarning) as error:
        raise UserError(f"{path} is not a whole recording ({error}); delete it and record the run again") from error
    names, batches = {}, defaultdict(list)
    for chunk in chunks:
        batch = chunk.to_record_batch()
        if "SeriesLines:names" in batch.schema.names:
            names[chunk.entity_path] = tuple(batch["SeriesLines:names"][0].as_py())
        if "Scalars:scalars" in batch.schema.names:
            batches[chunk.entity_path].append(batch)
    return {entity.removeprefix("/"): _track(batches[entity], lines) for entity, lines in names.items()}


def card_page(title: str, card: Mapping[str, object]) -> str:
    """The run card in Markdown: a table of the plain entries, and one of each nested dictionary, by dotted keys."""
    plain = {key: value for key, value in card.items() if not isinstance(value, Mapping)}
    nested = {key: flattened(value) for key, value in card.items() if isinstance(value, Mapping)}
    tables = ({"Run": plain} if plain else {}) | nested
    return "\n\n".join([f"## {title}", *(_table(name, entries) for name, entries in tables.items())]) + "\n"


def _table(name: str, entries: Mapping[str, object]) -> str:
    rows = [f"| {key} | {_cell(value)} |" for key, value in entries.items()]
    return "\n".join([f"| {name} |  |", "| --- | --- |", *rows])


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, list | tuple):
        return ", ".join(_cell(entry) for entry in value)
    return "–" if value is None else str(value).replace("|", "\\|").replace("\n", " ")


def _check(path: Path, expected: set[str], rows: int) -> None:
    """Read the file back, since the library raises nothing when a write fails."""
    try:
        tracks = read_recording(path)
    except UserError as error:
        with path.open("ab") as stream:  # the write that fails says why, for instance that the disk is full
            stream.write(bytes(1 << 20))
            stream.flush()
            os.fsync(stream.fileno())
        raise OSError(f"the recording was not written completely: {error}") from error
    if not expected <= tracks.keys() or any(len(tracks[entity].at) != rows for entity in expected):
        raise OSError("the recording was not written completely: rows are missing")


def _track(batches: list[Any], names: tuple[str, ...]) -> Track:
    timeline = next(name for name in (TIMELINE, LEARNING_TIMELINE) if name in batches[0].schema.names)
    at = np.concatenate([batch[timeline].cast("int64").to_numpy() for batch in batches])
    flat = np.concatenate([batch["Scalars:scalars"].flatten().to_numpy() for batch in batches])
    order = np.argsort(at, kind="stable")
    return Track(
        timeline, at[order] * 1e-9 if timeline == TIMELINE else at[order], flat.reshape(-1, len(names))[order], names
    )
