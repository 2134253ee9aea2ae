"""Makes a dataset and stores it."""

from collections.abc import Mapping
from pathlib import Path
from typing import assert_never

from repro.data.data_options import FreeMotionOptions, RandomForce, RecordingFile
from repro.data.dataset import Dataset
from repro.data.free_motion import free_motion
from repro.data.random_force import random_force
from repro.data.recording_file import from_file
from repro.mechanics.system import load_system
from repro.pipeline.stage_options import DataOptions
from repro.tracking import progress
from repro.tracking.plain_data import Json
from repro.tracking.record import Record


def make(folder: Path, options: DataOptions, upstream: Mapping[str, Record]) -> Json:
    """Simulate D or D_H, or read a recording in the coordinates of the system; UserError for what is not allowed."""
    dataset = _dataset(options)
    warnings = dataset.provenance.get("warnings")
    for warning in warnings if isinstance(warnings, list) else ():
        progress.notice(f"{dataset.provenance['file']}: {warning}")
    dataset.save(folder)
    return {
        "members": dataset.members,
        "samples": dataset.samples,
        "n_train": dataset.n_train,
        "provenance": dict(dataset.provenance),
    }


def _dataset(options: DataOptions) -> Dataset:
    system = None if options.system is None else load_system(options.system)
    source = options.source
    match source:
        case RandomForce():
            assert system is not None
            return random_force(system, options.seeds, source)
        case FreeMotionOptions():
            assert system is not None
            return free_motion(system, options.seeds, source)
        case RecordingFile():
            return from_file(source, system, members=len(options.seeds))
        case _:
            assert_never(source)
