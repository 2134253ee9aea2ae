"""Closed loops as a stage: drives the true plant from many starts, and writes the results as tables."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from repro.control.loop_tables import row, save, trajectory
from repro.control.task import LoopPlan
from repro.data.dataset import Dataset
from repro.learning.result import Progress
from repro.library.closed_loops import closed_loops
from repro.mechanics.system import System
from repro.models.model import Model
from repro.pipeline.stage_options import LoopOptions
from repro.pipeline.stages.stored_fit import dataset, load_parameters, model_of, simulated_system
from repro.tracking import progress
from repro.tracking.files import write_json
from repro.tracking.load import Run
from repro.tracking.paths import CHECKPOINT_PREFIX
from repro.tracking.plain_data import Json

LOOPS, TRAJECTORIES, FIRST = "control.parquet", "closed_loops.parquet", "first_loop.npz"
SHOWN = 2  # loops whose trajectories are stored
# What the loops so far have left; a stage that was interrupted finds these files again.
_SO_FAR, _FIRST_SO_FAR = f"{CHECKPOINT_PREFIX}-loops.json", f"{CHECKPOINT_PREFIX}-{FIRST}"


def make(folder: Path, options: LoopOptions, upstream: Mapping[str, Run]) -> Json:
    """Close the loops with the fitted ensemble upstream."""
    fit, inputs = upstream["fit"], upstream["fit"].upstream
    model, weights = model_of(options.fit, inputs), load_parameters(fit.record.folder)
    system, data = simulated_system(options.fit), dataset(inputs["data"])
    return drive(folder, model, weights, options.fit.seeds, system, data, options, progress.report)


def drive(
    folder: Path,
    model: Model,
    parameters: np.ndarray,
    seeds: Sequence[int],
    system: System,
    data: Dataset,
    plan: LoopPlan,
    report: Progress,
) -> Json:
    """Close every loop of a plan with the members' weights (member, n_parameters); returns a summary."""
    disc = plan.task.disc(system)
    finished = json.loads((folder / _SO_FAR).read_bytes()) if (folder / _SO_FAR).exists() else {}
    rows, trajectories = finished.get("rows", []), [tuple(point) for point in finished.get("trajectories", [])]
    for number, member, loop in closed_loops(model, parameters, system, data, plan, report, first=len(rows)):
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
