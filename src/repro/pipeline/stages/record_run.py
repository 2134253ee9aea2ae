"""Turn an evaluated run's stored tables into a rerun recording."""

from pathlib import Path

from repro.library.run_recording import record
from repro.pipeline.stage_options import RecordingOptions
from repro.pipeline.stages.stored_fit import simulated_system
from repro.recording.contents import FILENAME
from repro.tracking.load import Run


def make(folder: Path, options: RecordingOptions, run: Run, command: str) -> dict[str, int]:
    """Record a stored run."""
    summary = run.record.summary
    card = {**summary["card"], "test medians": summary["median"], "command": command}
    tables = run.table("trajectories"), run.table("curves")
    return record(folder / FILENAME, run.id, options.title, card, *tables, simulated_system(options.fit))
