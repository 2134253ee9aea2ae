"""The recording of a closed loop: plant, obstacle, predicted horizon, clearance, and what the solver did."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from repro.codegen.evaluate import evaluate
from repro.control.closed_loop import SUBSTEPS
from repro.control.loop_tables import energies
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.recording.contents import Rollout, RunRecording
from repro.recording.writer import write_recording

FILE = "recording.rrd"
FALLBACKS = "fallback (1 second try, 2 last plan, 3 none)"


def record(
    folder: Path, run: str, title: str, card: Mapping[str, Any], loop: Mapping[str, np.ndarray], system: System
) -> dict[str, Any]:
    """Write recording.rrd of a kept loop, as `loop_tables.keep` leaves it, up to where it was given up."""
    states = loop["states"][::SUBSTEPS]
    steps = int(np.sum(np.all(np.isfinite(states), axis=1)))
    states, time = states[:steps], loop["time"][::SUBSTEPS][:steps]
    force, predicted = (_for_each(loop[name], steps) for name in ("forces", "predicted"))
    charts = {
        "solver time": ("ms", _for_each(loop["milliseconds"], steps)),
        "iterations": ("", _for_each(loop["iterations"], steps)),
        FALLBACKS: ("", _for_each(loop["fallbacks"], steps)),
    }
    if loop["clearance"].size:
        charts["clearance"] = ("m", loop["clearance"][::SUBSTEPS][:steps])
    recording = RunRecording(
        run=run,
        title=title,
        card=card,
        time=time,
        coordinates=[(c.name, c.unit) for c in system.coordinates],
        plant=Rollout(state=states, energies=energies(system, states), points=_points(system, states)),
        models={},
        force=force,
        power=_power(system, states, force, time),
        obstacle=(*loop["obstacle"],) if loop["obstacle"].size else None,
        predicted=_points(system, predicted)[:, :, -1],
        charts={name: (unit, np.asarray(values, dtype=float)) for name, (unit, values) in charts.items()},
    )
    write_recording(folder / FILE, recording)
    return {"steps": steps}


def _for_each(values: np.ndarray, steps: int) -> np.ndarray:
    """Values of each control step for each sample; the last sample, after which nothing is decided, repeats one."""
    return np.append(values, values[-1:], axis=0)[:steps]


def _points(system: System, states: np.ndarray) -> np.ndarray:
    """World points (..., n_points, 2)."""
    components = [states[..., i] for i in range(system.n_q)]
    points = [np.stack(np.broadcast_arrays(*point), axis=-1) for point in system.body_points(components, np)]
    return np.stack(points, axis=-2)


def _power(system: System, states: np.ndarray, force: np.ndarray, time: np.ndarray) -> dict[str, np.ndarray]:
    """Mean powers over each step; the force is held, so that f dx / dt is exact."""
    energy = evaluate(dynamics_of(system).hamiltonian, states[:, : system.n_q], states[:, system.n_q :])[:, 0]
    steps = np.diff(time)
    supplied = np.append(force[:-1] * np.diff(states[:, 0]) / steps, 0.0)
    stored = np.append(np.diff(energy) / steps, 0.0)
    return {"supplied": supplied, "dH/dt": stored, "dissipated": supplied - stored}
