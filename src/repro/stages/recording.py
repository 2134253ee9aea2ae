"""Turn an evaluated run's stored tables into a rerun recording."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.mechanics.system import System
from repro.tracking.recording import Curve, Rollout, RunRecording, write_recording

FILE = "recording.rrd"
SHOWN = 3  # members: more make the picture crowded


def record(
    folder: Path,
    run: str,
    title: str,
    card: Mapping[str, Any],
    trajectories: pd.DataFrame,
    curves: pd.DataFrame,
    system: System,
) -> dict[str, Any]:
    """Write recording.rrd: the first member's plant and model over the first test points, learning curves of a few."""
    members = sorted(trajectories["member"].unique())[:SHOWN]
    along_the_test = ~trajectories["name"].str.startswith("free.")
    first = trajectories[(trajectories["member"] == members[0]) & along_the_test]
    table = first.pivot(index="t", columns="name", values="value").sort_index()
    time = table.index.to_numpy()
    coordinates = [(c.name, c.unit) for c in system.coordinates]
    names = [name for name, _ in coordinates] + [f"{name}d" for name, _ in coordinates]
    plant = _rollout(table, "plant", names, system)
    recording = RunRecording(
        run=run,
        title=title,
        card=card,
        time=time,
        coordinates=coordinates,
        plant=plant,
        models={f"seed {members[0]}": _rollout(table, "model", names, system)},
        force=table["force"].to_numpy(),
        power=_power(table, plant.energies["H"], time, system),
        curves=_curves(curves, members),
    )
    write_recording(folder / FILE, recording)
    return {"member": int(members[0])}


def _rollout(table: pd.DataFrame, role: str, names: Sequence[str], system: System) -> Rollout:
    state = table[[f"{role}.{name}" for name in names]].to_numpy()
    components = [state[:, index] for index in range(system.n_q)]
    points = [[np.broadcast_to(value, len(state)) for value in point] for point in system.body_points(components, np)]
    energies = {name: table[f"{role}.{name}"].to_numpy() for name in ("T", "V", "H")}
    return Rollout(state=state, energies=energies, points=np.moveaxis(np.array(points), 2, 0))


def _power(table: pd.DataFrame, energy: np.ndarray, time: np.ndarray, system: System) -> dict[str, np.ndarray]:
    """Mean powers over each step, zero across the restart of an episode; the force is held, so f dx / dt is exact."""
    position = table[f"plant.{system.coordinates[0].name}"].to_numpy()
    steps = np.diff(time)
    supplied = np.append(table["force"].to_numpy()[:-1] * np.diff(position) / steps, 0.0)
    stored = np.append(np.diff(energy) / steps, 0.0)
    restart = np.append(np.diff(table["episode"].to_numpy()) != 0, False)
    supplied[restart], stored[restart] = 0.0, 0.0
    return {"supplied": supplied, "dH/dt": stored, "dissipated": supplied - stored}


def _curves(curves: pd.DataFrame, members: Sequence[int]) -> dict[str, Curve]:
    result = {}
    for name, rows in curves.groupby("name"):
        table = rows.pivot_table(index="step", columns="member", values="value").sort_index()
        shown = [member for member in members if member in table]
        positive = table[shown].where(table[shown] > 0)
        values = {f"seed {member}": np.log10(positive[member].to_numpy()) for member in shown}
        result[f"log10 {name}"] = Curve(step=table.index.to_numpy(), values=values)
    return result
