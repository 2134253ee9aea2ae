"""Turn an evaluated run's stored tables into a rerun recording."""

from collections.abc import Mapping
from pathlib import Path

from repro.library.run_recording import record
from repro.pipeline.stage_options import RecordingOptions
from repro.pipeline.stages.stored_fit import simulated_system
from repro.recording.contents import FILENAME
from repro.tracking.record import Record


def make(folder: Path, options: RecordingOptions, upstream: Mapping[str, Record]) -> dict[str, int]:
    """Record a stored run."""
    run = upstream["run"]
    summary = run.summary
    card = {**summary["card"], "test medians": summary["median"], "command": run.provenance.command}
    tables = run.table("trajectories"), run.table("curves")
    return record(folder / FILENAME, run.id, options.title, card, *tables, simulated_system(options.fit))
