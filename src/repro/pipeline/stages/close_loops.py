"""Closed loops as a stage: drives the true plant from many starts, and writes the results as tables."""

import json
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from repro.control.loop_tables import row, save, trajectory
from repro.control.task import LoopPlan
from repro.library.closed_loops import closed_loops
from repro.library.ensemble_model import Ensemble
from repro.pipeline.stage_options import LoopOptions
from repro.pipeline.stages.stored_fit import ensemble_of
from repro.tracking import progress
from repro.tracking.files import write_json
from repro.tracking.paths import CHECKPOINT_PREFIX
from repro.tracking.plain_data import Json
from repro.tracking.record import Record

LOOPS, TRAJECTORIES, FIRST = "control.parquet", "closed_loops.parquet", "first_loop.npz"
SHOWN = 2  # loops whose trajectories are stored
# What the loops so far have left; a stage that was interrupted finds these files again.
_SO_FAR, _FIRST_SO_FAR = f"{CHECKPOINT_PREFIX}-loops.json", f"{CHECKPOINT_PREFIX}-{FIRST}"


def make(folder: Path, options: LoopOptions, upstream: Mapping[str, Record]) -> Json:
    """Close the loops with the fitted ensemble upstream."""
    return drive(folder, ensemble_of(options.fit, upstream["fit"]), options)


def drive(folder: Path, ensemble: Ensemble, plan: LoopPlan) -> Json:
    """Close every loop of a plan on the true system; returns a summary."""
    system, seeds = ensemble.system, ensemble.seeds
    assert system is not None
    disc = plan.task.disc(system)
    finished = json.loads((folder / _SO_FAR).read_bytes()) if (folder / _SO_FAR).exists() else {}
    rows, trajectories = finished.get("rows", []), [tuple(point) for point in finished.get("trajectories", [])]
    for number, member, loop in closed_loops(ensemble, system, plan, progress.report, first=len(rows)):
        rows.append(row(loop, seeds[member]))
        if number < SHOWN:
            trajectories += [(number, seeds[member], *point) for point in trajectory(loop, disc)]
        if number == 0:
            save(folder / _FIRST_SO_FAR, loop, disc)
        write_json(folder / _SO_FAR, {"rows": rows, "trajectories": trajectories})
    (folder / _FIRST_SO_FAR).rename(folder / FIRST)
    table = pd.DataFrame(rows)
    table.to_parquet(folder / LOOPS, index=False)
    columns = ["loop", "member", "x_des", "name", "t", "value"]
    pd.DataFrame(trajectories, columns=columns).to_parquet(folder / TRAJECTORIES, index=False)
    return {
        "loops": len(rows),
        "success": float(table["success"].mean()),
        "contacts": int(table["contact"].sum()),
        "killed": int(table["killed"].sum()),
    }
