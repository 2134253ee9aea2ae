"""The recording of a run: a motion of the plant, the models beside it, energies, power and learning curves."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from repro.errors import UserError
from repro.evaluation.power_balance import power_balance
from repro.evaluation.rollouts import first_points
from repro.library.drawn_motion import drawn_coordinates, drawn_shapes, driven_forces, named_inputs
from repro.library.ensemble_model import Ensemble
from repro.library.signals import signals
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.inputs import inputs_from_force
from repro.mechanics.system import System
from repro.recording.contents import DrawnMotion, LearningCurve, RunRecording
from repro.recording.writer import write_recording

ENERGIES = ("T", "V", "H")
SHOWN = 3  # members: more make the picture crowded


def record(
    path: Path,
    run: str,
    title: str,
    card: Mapping[str, object],
    trajectories: pd.DataFrame,
    curves: pd.DataFrame,
    mechanism: System | Sequence[Coordinate],
) -> dict[str, int]:
    """Record the first member's plant and model over the first test points, and learning curves of a few."""
    members = trajectories["member"].unique()[:SHOWN]
    tested = {f"seed {members[0]}": tested_by(trajectories, members[0])}
    learned = {f"seed {member}": curves[curves["member"] == member] for member in members}
    write_recording(path, recording_of(run, title, card, tested, learned, mechanism))
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
    mechanism: System | Sequence[Coordinate],
) -> RunRecording:
    """The plant and one or several models that were tested along the same motion of it.

    tested     label -> signals, as `tested_by` gives them; the first ones' plant, force and restarts are shown
    learned    label -> rows of curves.parquet
    mechanism  the true system, or the coordinates alone where it is not known: then the picture has a hand for each
               angle and a block for each length, and there is no true energy to compare with
    """
    first = next(iter(tested.values()))
    time = first.index.to_numpy()
    system = mechanism if isinstance(mechanism, System) else None
    coordinates = mechanism.coordinates if isinstance(mechanism, System) else mechanism
    names = [c.name for c in coordinates] + [f"{c.name}d" for c in coordinates]
    tau = first[[f"tau[{index}]" for index in range(len(coordinates))]].to_numpy()

    def motion(table: pd.DataFrame, role: str) -> DrawnMotion:
        state = table[[f"{role}.{name}" for name in names]].to_numpy()
        if system is None:
            return DrawnMotion(state, {}, drawn_coordinates(coordinates, state))
        absent = pd.Series(np.nan, index=table.index)
        energies = {name: table.get(f"{role}.{name}", absent).to_numpy() for name in ENERGIES}
        return DrawnMotion(state, energies, drawn_shapes(system, state))

    def spread(table: pd.DataFrame) -> np.ndarray | None:
        columns = [f"standard_error.{name}" for name in names]
        return table[columns].to_numpy() if columns[0] in table else None

    plant = motion(first, "plant")
    q, qd = np.split(plant.state, 2, axis=1)
    inputs, forces = np.zeros((len(time), 0)), {c.name: tau[:, i] for i, c in enumerate(coordinates)}
    power, charts = {"supplied": (tau * qd).sum(axis=1)}, {}
    if system is not None:
        inputs, forces = inputs_from_force(system, q, tau), driven_forces(system, tau)
        power = power_balance(system, plant.state, inputs, plant.energies["H"], time)
    else:
        charts = {
            f"{name} of {label}": ("J", table[f"model.{name}"].to_numpy())
            for label, table in tested.items() for name in ENERGIES if f"model.{name}" in table
        }  # fmt: skip
    restart = np.append(np.diff(first["episode"].to_numpy()) != 0, False)
    return RunRecording(
        run=run,
        title=title,
        card=card,
        time=time,
        coordinates=[(c.name, c.unit) for c in coordinates],
        plant=plant,
        models={label: replace(motion(table, "model"), spread=spread(table)) for label, table in tested.items()},
        forces=forces,
        inputs={} if system is None else named_inputs(system, inputs),
        power={name: np.where(restart, 0.0, values) for name, values in power.items()},
        curves=_curves(learned),
        charts=charts,
    )


def _curves(learned: Mapping[str, pd.DataFrame]) -> dict[str, LearningCurve]:
    """Every quantity by name; as a logarithm unless some are negative, since the viewer has no logarithmic axis.

    A curve is constant between its own steps, and not finite after its last one.
    """
    result = {}
    for name in dict.fromkeys(name for rows in learned.values() for name in rows["name"]):
        lines = {label: rows[rows["name"] == name].groupby("step")["value"].mean() for label, rows in learned.items()}
        lines = {label: line for label, line in lines.items() if len(line)}
        together = pd.concat(lines.values())
        logarithmic = not (together < 0).any()
        steps = together.index.unique().sort_values()
        held = {label: line.reindex(steps).ffill().where(steps <= line.index[-1]) for label, line in lines.items()}
        values = {label: line.to_numpy() for label, line in held.items()}
        if logarithmic:
            values = {label: np.log10(np.where(line > 0, line, np.nan)) for label, line in values.items()}
        result[f"log10 {name}" if logarithmic else name] = LearningCurve(step=steps.to_numpy(), values=values)
    return result


def record_ensemble(ensemble: Ensemble, path: Path) -> Path:
    """See `FittedModel.record`."""
    model, test, system = ensemble.model, ensemble.data.test, ensemble.system
    if not model.n_parameters:
        raise UserError(f"{type(model).__name__} has no weights, so no motion of its own to record")
    rollout = first_points(model, ensemble.weights_, test, system)
    rows = signals(replace(ensemble, information_=None), rollout)
    if system is None and model.energetic:
        energies = ensemble.member(0).energies(*np.split(rollout.model[0], 2, axis=-1))
        values = energies.kinetic, energies.potential, energies.hamiltonian
        for name, each in zip(ENERGIES, values, strict=True):
            rows += [(ensemble.seeds[0], f"model.{name}", *at) for at in zip(rollout.time, each[0], strict=True)]
    trajectories = pd.DataFrame(rows, columns=["member", "name", "t", "value"])
    curves = pd.DataFrame(
        [(member, step, name, value) for step, name, values in ensemble.curves_
         for member, value in zip(ensemble.seeds, values, strict=True)],
        columns=["member", "step", "name", "value"],
    )  # fmt: skip
    name = type(getattr(model, "module", model)).__name__  # the user's own, where the model wraps one
    title = f"{name} of {'a recording' if system is None else system.name}"
    card = {"model": name, "seeds": list(ensemble.seeds), "data": dict(ensemble.data.provenance)}
    mechanism = test.coordinates if system is None else system
    identity = hashlib.sha256(ensemble.weights_.tobytes()).hexdigest()[:12]
    record(path, f"fit-{identity}", title, card, trajectories, curves, mechanism)
    return path
