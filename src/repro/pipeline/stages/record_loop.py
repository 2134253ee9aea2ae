"""The recording of a closed loop: plant, obstacle, predicted horizon, clearance, and what the solver did."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from repro.control.closed_loop import SUBSTEPS
from repro.evaluation.power_balance import power_balance
from repro.library.drawn_motion import drawn_shapes, driven_forces, named_inputs, tips
from repro.mechanics.derive import energies_along
from repro.mechanics.inputs import generalised_force
from repro.mechanics.system import System
from repro.pipeline.stage_options import RecordingOptions
from repro.pipeline.stages.close_loops import FIRST, LOOPS
from repro.pipeline.stages.stored_fit import simulated_system
from repro.recording.contents import FILENAME, DrawnMotion, RunRecording
from repro.recording.writer import write_recording
from repro.tracking.record import Record

FALLBACKS = "fallback: 1 second try, 2 last plan, 3 none"


def make(folder: Path, options: RecordingOptions, upstream: Mapping[str, Record]) -> dict[str, int]:
    """Record the first closed loop of a stored run."""
    run = upstream["run"]
    closed = run.upstream["control"]
    first = pd.read_parquet(closed.path(LOOPS)).iloc[0].to_dict()
    card = {**run.summary["card"], "first loop": first, "command": run.provenance.command}
    with np.load(closed.path(FIRST)) as stored:
        loop = dict(stored)
    return record(folder, run.id, options.title, card, loop, simulated_system(options.fit))


def record(
    folder: Path, run: str, title: str, card: Mapping[str, object], loop: Mapping[str, np.ndarray], system: System
) -> dict[str, int]:
    """Write recording.rrd of a stored loop, as `loop_tables.save` writes it, up to where it was stopped."""
    states = loop["states"][::SUBSTEPS]
    steps = int(np.sum(np.all(np.isfinite(states), axis=1)))
    states, time = states[:steps], loop["time"][::SUBSTEPS][:steps]
    inputs, predicted = (_for_each(loop[name], steps) for name in ("inputs", "predicted"))
    charts = {
        "solver time": ("ms", _for_each(loop["milliseconds"], steps)),
        "iterations": ("", _for_each(loop["iterations"], steps)),
        FALLBACKS: ("", _for_each(loop["fallbacks"], steps)),
    }
    if loop["clearance"].size:
        charts["clearance"] = ("m", loop["clearance"][::SUBSTEPS][:steps])
    tau = generalised_force(system, states[:, : system.n_q], inputs)
    energy = energies_along(system, states)
    recording = RunRecording(
        run=run,
        title=title,
        card=card,
        time=time,
        coordinates=[(c.name, c.unit) for c in system.coordinates],
        plant=DrawnMotion(state=states, energies=energy, shapes=drawn_shapes(system, states)),
        models={},
        forces=driven_forces(system, tau),
        inputs=named_inputs(system, inputs),
        power=power_balance(system, states, inputs, energy["H"], time),
        obstacle=(*loop["obstacle"],) if loop["obstacle"].size else None,
        predicted=tips(system, predicted),
        charts={name: (unit, np.asarray(values, dtype=float)) for name, (unit, values) in charts.items()},
    )
    write_recording(folder / FILENAME, recording)
    return {"steps": steps}


def _for_each(values: np.ndarray, steps: int) -> np.ndarray:
    """Values of each control step for each sample; the last sample, which starts no control step, repeats one."""
    return np.append(values, values[-1:], axis=0)[:steps]
