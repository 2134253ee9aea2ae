"""Turn an evaluated run's stored tables into a rerun recording."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from repro.evaluation.power_balance import power_balance
from repro.mechanics.inputs import inputs_from_force
from repro.mechanics.system import System
from repro.pipeline.stage_options import RecordingOptions
from repro.pipeline.stages.drawn_motion import drawn_shapes, driven_forces, named_inputs
from repro.pipeline.stages.stored_fit import simulated_system
from repro.recording.contents import FILENAME, DrawnMotion, LearningCurve, RunRecording
from repro.recording.writer import write_recording
from repro.tracking.load import Run

SHOWN = 3  # members: more make the picture crowded


def make(folder: Path, options: RecordingOptions, run: Run, command: str) -> dict[str, int]:
    """Record a stored run."""
    summary = run.record.summary
    card = {**summary["card"], "test medians": summary["median"], "command": command}
    tables = run.table("trajectories"), run.table("curves")
    return record(folder, run.id, options.title, card, *tables, simulated_system(options.fit))


def record(
    folder: Path,
    run: str,
    title: str,
    card: Mapping[str, object],
    trajectories: pd.DataFrame,
    curves: pd.DataFrame,
    system: System,
) -> dict[str, int]:
    """Write recording.rrd: the first member's plant and model over the first test points, learning curves of a few."""
    members = sorted(trajectories["member"].unique())[:SHOWN]
    tested = {f"seed {members[0]}": tested_by(trajectories, members[0])}
    learned = {f"seed {member}": curves[curves["member"] == member] for member in members}
    write_recording(folder / FILENAME, recording_of(run, title, card, tested, learned, system))
    return {"member": int(members[0])}


def tested_by(trajectories: pd.DataFrame, member: int) -> pd.DataFrame:
    """One member's signals along the test set: one column per signal, indexed by time."""
    is_test = ~trajectories["name"].str.startswith("free.")
    rows = trajectories[(trajectories["member"] == member) & is_test]
    return rows.pivot(index="t", columns="name", values="value").sort_index()


def recording_of(
    run: str,
    title: str,
    card: Mapping[str, object],
    tested: Mapping[str, pd.DataFrame],
    learned: Mapping[str, pd.DataFrame],
    system: System,
) -> RunRecording:
    """The plant and one or several models that were tested along the same motion of it.

    tested   label -> signals, as `tested_by` gives them; the first ones' plant, force and restarts are shown
    learned  label -> rows of curves.parquet
    """
    first = next(iter(tested.values()))
    time = first.index.to_numpy()
    coordinates = [(c.name, c.unit) for c in system.coordinates]
    names = [name for name, _ in coordinates] + [f"{name}d" for name, _ in coordinates]
    plant = _motion(first, "plant", names, system)
    tau = first[[f"tau[{index}]" for index in range(system.n_q)]].to_numpy()
    inputs = inputs_from_force(system, plant.state[:, : system.n_q], tau)
    power = power_balance(system, plant.state, inputs, plant.energies["H"], time)
    restart = np.append(np.diff(first["episode"].to_numpy()) != 0, False)
    return RunRecording(
        run=run,
        title=title,
        card=card,
        time=time,
        coordinates=coordinates,
        plant=plant,
        models={label: _motion(table, "model", names, system) for label, table in tested.items()},
        forces=driven_forces(system, tau),
        inputs=named_inputs(system, inputs),
        power={name: np.where(restart, 0.0, values) for name, values in power.items()},
        curves=_curves(learned),
    )


def _motion(table: pd.DataFrame, role: str, names: Sequence[str], system: System) -> DrawnMotion:
    state = table[[f"{role}.{name}" for name in names]].to_numpy()
    absent = pd.Series(np.nan, index=table.index)
    energies = {name: table.get(f"{role}.{name}", absent).to_numpy() for name in ("T", "V", "H")}
    return DrawnMotion(state=state, energies=energies, shapes=drawn_shapes(system, state))


def _curves(learned: Mapping[str, pd.DataFrame]) -> dict[str, LearningCurve]:
    """Every quantity by name; as a logarithm unless some are negative, since the viewer has no logarithmic axis."""
    result = {}
    for name in dict.fromkeys(name for rows in learned.values() for name in rows["name"]):
        lines = {label: rows[rows["name"] == name].groupby("step")["value"].mean() for label, rows in learned.items()}
        lines = {label: line for label, line in lines.items() if len(line)}
        together = pd.concat(lines.values())
        logarithmic = not (together < 0).any()
        steps = together.index.unique().sort_values()
        values = {label: _held(line, steps) for label, line in lines.items()}
        if logarithmic:
            values = {label: np.log10(np.where(line > 0, line, np.nan)) for label, line in values.items()}
        result[f"log10 {name}" if logarithmic else name] = LearningCurve(step=steps.to_numpy(), values=values)
    return result


def _held(line: pd.Series, steps: pd.Index) -> np.ndarray:
    """A curve at the steps of all curves: constant between its own steps, not finite after its last."""
    return line.reindex(steps).ffill().where(steps <= line.index[-1]).to_numpy()
