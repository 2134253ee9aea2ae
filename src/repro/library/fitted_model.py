"""A fitted ensemble, and what can be asked of it with plain arrays."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import casadi
import numpy as np
from numpy.typing import ArrayLike

from repro.codegen.array_evaluation import evaluate
from repro.control.controller import ControllerOptions
from repro.control.task import Task
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.evaluation.metrics import pointwise
from repro.evaluation.model_motion import model_motion
from repro.evaluation.predictions import at_rest, predict
from repro.learning.result import Curve, Progress, silent
from repro.library.closed_loops import Controlled, control
from repro.mechanics.system import System
from repro.models.gauge import Gauge
from repro.models.model import Model
from repro.models.terms import Terms

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

WEIGHTS, ABOUT = "weights.npz", "about.json"


@dataclass(frozen=True)
class EnergyValues:
    """T, V and H = p . qd - L in J, each (member, ...)."""

    kinetic: np.ndarray
    potential: np.ndarray
    hamiltonian: np.ndarray


@dataclass(frozen=True)
class FittedModel:
    """An ensemble with its weights. Inputs are (..., n_q) in SI units; the first axis of what comes out is the member.

    model    the model that all members share
    weights_ (member, n_parameters)
    seeds    of each member
    data     what it was fitted to
    status_  "ok" or "diverged at ...", one per member
    seconds_ CPU time of the fit
    curves_  (step, name, one value per member) of the fit
    system   the true system, where it is known
    """

    model: Model
    weights_: np.ndarray
    seeds: tuple[int, ...]
    data: Dataset
    status_: tuple[str, ...] = ()
    seconds_: float = 0.0
    curves_: "Curve | tuple[()]" = ()
    system: System | None = None

    @property
    def members(self) -> int:
        """Number of members."""
        return len(self.weights_)

    def member(self, index: int) -> "FittedModel":
        """One member alone, as an ensemble of one."""
        part = slice(index, index + 1)
        arrays = {name: getattr(self.data, name)[part] for name in ("q", "qd", "qdd", "tau")}
        energy = None if self.data.energy is None else self.data.energy[part]
        curves = [(step, name, values[part]) for step, name, values in self.curves_]
        return replace(
            self, weights_=self.weights_[part], seeds=self.seeds[part], status_=self.status_[part], curves_=curves,
            data=replace(self.data, **arrays, energy=energy),
        )  # fmt: skip

    def tau(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> np.ndarray:
        """Forces of the inverse model, (member, ..., n_q) in N or N m; UserError for one that has none."""
        return self._defined("tau", self._predicted(q, qd, qdd))

    def acceleration(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> np.ndarray:
        """qdd of the forward dynamics, (member, ..., n_q) in m/s^2 or rad/s^2."""
        return self._defined("acceleration", self._predicted(q, qd, tau=tau))

    predict = acceleration

    def momentum(self, q: ArrayLike, qd: ArrayLike) -> np.ndarray:
        """p = dL/dqd, (member, ..., n_q) in kg m/s or kg m^2/s."""
        return self._defined("momentum", self._predicted(q, qd))

    def mass_matrix(self, q: ArrayLike, qd: ArrayLike | None = None) -> np.ndarray:
        """M = d2L/dqd2, (member, ..., n_q, n_q) in kg or kg m^2; at rest unless qd is given."""
        return self._defined("mass", self._predicted(q, np.zeros_like(q, dtype=float) if qd is None else qd))

    def energies(self, q: ArrayLike, qd: ArrayLike, *, canonical: bool = True) -> EnergyValues:
        """T, V and H, (member, ...) in J.

        L is unique only up to a constant and dF(q)/dt. canonical: T is 0 and least at rest, T - T(q, 0) - p(q, 0) . qd;
        otherwise T and V are as the model has them. H is defined up to a constant.
        """
        terms, (flat_q, flat_qd) = self._flat(q, qd)
        shape = np.broadcast_shapes(np.shape(q), np.shape(qd))[:-1]
        kinetic, potential = self._defined("kinetic", terms), self._defined("potential", terms)
        if canonical:
            rest = at_rest(self.model, self.weights_, flat_q)
            kinetic = kinetic - rest.kinetic - (rest.momentum * flat_qd).sum(-1)
            potential = potential - rest.kinetic
        values = kinetic, potential, terms.hamiltonian(flat_qd)
        return EnergyValues(*(value.reshape(self.members, *shape) for value in values))

    def port_form(self, q: ArrayLike, qd: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """dH/dx and (J - R) dH/dx of eq. (5) at x = [q; p], (member, ..., 2 n_q) each.

        UserError for a model without energies, or without a symbolic form.
        """
        self._needs_expressions("port_form")
        positions, velocities = np.asarray(q, dtype=float), np.asarray(qd, dtype=float)
        rows = np.stack([evaluate(self._port, positions, velocities, weights) for weights in self.weights_])
        gradient, drift = np.split(rows, 2, axis=-1)
        return gradient, drift

    def rollout(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, time_step: float | None = None) -> np.ndarray:
        """The motion from q, qd (n_q,) under tau (steps, n_q), held over each step of time_step s (that of the data).

        Returns states [q, qd], (member, steps + 1, 2 n_q); not finite from where a member diverges.
        """
        start = np.concatenate([np.asarray(q, dtype=float), np.asarray(qd, dtype=float)])
        force = np.asarray(tau, dtype=float)
        if start.shape != (2 * self.model.n_q,) or force.shape[1:] != (self.model.n_q,):
            raise UserError(
                f"rollout: q and qd need {self.model.n_q} numbers each and tau (steps, {self.model.n_q}); "
                f"got {np.shape(q)}, {np.shape(qd)}, {force.shape}"
            )
        initial, held = (np.repeat(array[None], self.members, axis=0) for array in (start, force))
        step = self.data.time_step if time_step is None else time_step
        return model_motion(self.model, self.weights_, initial, held, step, self.data.angles)

    simulate = rollout

    def control(
        self,
        task: Task,
        controller: str | ControllerOptions = "mpc",
        *,
        plant: System | None = None,
        canonical: bool = True,
        progress: Progress = silent,
    ) -> Controlled:
        """Drive a plant with the model, from every start of a task; the members take turns.

        Parameters
        ----------
        task
            What `repro.task` returns: starts, goals, obstacle, disturbances.
        controller
            A name, or what `repro.controller` returns: horizon, weights, limits of the inputs.
        plant
            The system that is driven, by default the one that the model was fitted to.
        canonical
            Whether the energies in the cost are in the gauge in which T is 0 and least at rest.

        Raises
        ------
        UserError
            Where no plant is known, the task or the controller does not fit it, or the model has no expressions.
        """
        return control(self, task, controller, plant, canonical, progress)

    def score(self, data: Dataset | None = None) -> "pd.DataFrame":
        """Errors on the test part of the data (those of the fit by default): a row per metric, a column per seed.

        Names and units as in docs/results.md; energies are compared where the true system is known.
        """
        import pandas as pd

        from repro.library.datasets import for_members

        part = for_members(self.data if data is None else data, self.members).test
        metrics = pointwise(self.model, self.weights_, part, self.system, "test", Gauge.CANONICAL)
        rows = {metric.name: (metric.unit, *metric.values) for metric in metrics}
        return pd.DataFrame.from_dict(rows, orient="index", columns=["unit", *self.seeds])

    def plot(self) -> "Figure":
        """Measured and predicted forces, energies and the learning curve of the first member, over the test part."""
        from repro.library.plot import plot

        return plot(self)

    def export(self, folder: Path | str, member: int = 0) -> list[str]:
        """Write one member as CasADi functions, C and a torch module that need nothing of this project.

        Returns the names of the files. UserError when the folder has content, or there is no symbolic form.
        """
        from repro.export.member import LearnedMember, write

        self._needs_expressions("export")
        card: Mapping[str, object] = {"model": type(self.model).__name__, "data": dict(self.data.provenance)}
        name = "recorded" if self.system is None else self.system.name
        exported = LearnedMember(
            "fit", self.seeds[member], name, "repro.fit", card, self.model, self.weights_[member], self.data.coordinates
        )
        return write(exported, Path(folder))

    def save(self, folder: Path | str) -> None:
        """Write weights and data into a folder, for `load`."""
        folder = Path(folder)
        self.data.save(folder)
        np.savez(folder / WEIGHTS, weights=self.weights_)
        about = {"seeds": list(self.seeds), "status": list(self.status_), "seconds": self.seconds_}
        (folder / ABOUT).write_text(json.dumps(about, indent=2) + "\n")

    def load(self, folder: Path | str) -> "FittedModel":
        """The same model with the weights that `save` wrote; UserError where they do not fit."""
        folder = Path(folder)
        try:
            about = json.loads((folder / ABOUT).read_text())
            with np.load(folder / WEIGHTS) as stored:
                weights = stored["weights"]
        except (OSError, ValueError, KeyError) as error:
            raise UserError(f"{folder} holds no fitted model ({error})") from error
        if weights.shape[1] != self.model.n_parameters:
            raise UserError(f"{folder} has {weights.shape[1]} weights per seed, this model {self.model.n_parameters}")
        return replace(
            self, weights_=weights, seeds=tuple(about["seeds"]), status_=tuple(about["status"]),
            seconds_=about["seconds"], curves_=(), data=Dataset.load(folder),
        )  # fmt: skip

    def _repr_html_(self) -> str:
        medians = self.score().drop(columns="unit").median(axis=1)
        shown = medians[[name for name in medians.index if "[" not in name]]
        body = "".join(f"<tr><td>{name}</td><td>{value:.3g}</td></tr>" for name, value in shown.items())
        return (
            f"<b>{type(self.model).__name__}</b>: {self.model.n_parameters} weights, {self.members} seeds, "
            f"{self.seconds_:.2f} CPU s<table><tr><th>median on test data</th><th></th></tr>{body}</table>"
        )

    @cached_property
    def _port(self) -> casadi.Function:
        q, qd = casadi.SX.sym("q", self.model.n_q), casadi.SX.sym("qd", self.model.n_q)
        parameters = casadi.SX.sym("parameters", self.model.n_parameters)
        form = self.model.port_form(q, qd, parameters)
        rows = casadi.densify(casadi.vertcat(form.gradient, form.drift))
        return casadi.Function("port", [q, qd, parameters], [rows], {"cse": True})

    def _predicted(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike | None = None, tau: ArrayLike | None = None
    ) -> Terms:
        terms, shape = self._flat(q, qd, qdd, tau)[0], np.broadcast_shapes(np.shape(q), np.shape(qd))[:-1]
        names = ("tau", "acceleration", "momentum", "mass")
        arrays = {name: getattr(terms, name) for name in names}
        return Terms(
            **{
                name: None if array is None else array.reshape(self.members, *shape, *array.shape[2:])
                for name, array in arrays.items()
            }
        )

    def _flat(self, *arrays: ArrayLike | None) -> tuple[Terms, Sequence[np.ndarray]]:
        """Predictions at samples (member, sample, n_q) of broadcast arrays (..., n_q); absent ones are 0."""
        given = np.broadcast_arrays(*(np.zeros(self.model.n_q) if a is None else np.asarray(a, float) for a in arrays))
        if given[0].shape[-1] != self.model.n_q:
            raise UserError(f"arrays of shape {given[0].shape}: the last axis needs {self.model.n_q} coordinates")
        flat = [np.repeat(a.reshape(1, -1, self.model.n_q), self.members, axis=0) for a in given]
        padded = flat + [np.zeros_like(flat[0])] * (4 - len(flat))
        return predict(self.model, self.weights_, *padded), flat

    def _defined(self, name: str, terms: Terms) -> np.ndarray:
        value = getattr(terms, name)
        if value is None:
            raise UserError(f"{type(self.model).__name__} predicts no {name}")
        return np.asarray(value)

    def _needs_expressions(self, what: str) -> None:
        if self.model.not_symbolic is not None:
            raise UserError(f"{what} needs the model as expressions: {self.model.not_symbolic}")
