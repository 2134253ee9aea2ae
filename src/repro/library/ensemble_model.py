"""An ensemble with its weights, and its predictions from plain arrays."""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.evaluation.model_motion import model_motion
from repro.evaluation.predictions import predict
from repro.learning.result import Curve, Notes
from repro.mechanics.system import System
from repro.models.model import Model
from repro.models.terms import Terms

ALL = ("tau", "acceleration", "momentum", "kinetic", "potential", "mass")


@dataclass(frozen=True)
class EnergyValues:
    """T, V and H = p . qd - L in J, each (member, ...)."""

    kinetic: np.ndarray
    potential: np.ndarray
    hamiltonian: np.ndarray


@dataclass(frozen=True)
class Ensemble:
    """An ensemble with its weights.

    Inputs are (..., n_q) in SI units; the first axis of what comes out is the member. Predictions raise UserError for
    arrays of another width, and where the model does not define the quantity.

    model    the model that all members share
    weights_ (member, n_parameters)
    seeds    of each member
    data     what it was fitted to
    status_  "ok" or "diverged at ...", one per member
    seconds_ CPU time of the fit
    curves_  (step, name, one value per member) of the fit
    system   the true system, where it is known
    information_  Fisher information of the weights (member, n_parameters, n_parameters), where the fit has one
    notes_   what the fit reports beside
    """

    model: Model
    weights_: np.ndarray
    seeds: tuple[int, ...]
    data: Dataset
    status_: tuple[str, ...] = ()
    seconds_: float = 0.0
    curves_: "Curve | tuple[()]" = ()
    system: System | None = None
    information_: np.ndarray | None = None
    notes_: Notes = field(default_factory=Notes)

    @property
    def members(self) -> int:
        """Number of members."""
        return len(self.weights_)

    def member(self, index: int) -> Self:
        """One member alone.

        Parameters
        ----------
        index
            From 0.

        Returns
        -------
        Ensemble
            Of the same kind, with one member.
        """
        part = slice(index, index + 1)
        curves = [(step, name, values[part]) for step, name, values in self.curves_]
        information = None if self.information_ is None else self.information_[part]
        return replace(
            self, information_=information, weights_=self.weights_[part], seeds=self.seeds[part],
            status_=self.status_[part], curves_=curves, data=self.data.of_members([index]),
        )  # fmt: skip

    def tau(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> np.ndarray:
        """Forces of the inverse model, eq. (2).

        Parameters
        ----------
        q, qd, qdd
            Positions, velocities and accelerations (m, rad, s), (..., n_q); leading axes broadcast.

        Returns
        -------
        numpy.ndarray
            (member, ..., n_q) in N or N m.

        Examples
        --------
        >>> import repro
        >>> data = repro.simulate("sip", samples=200, reset="random")
        >>> fitted = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares")
        >>> fitted.tau([0.0, 0.5], [0.0, 0.0], [1.0, 0.0]).shape
        (1, 2)
        """
        return self._defined("tau", self._predicted(q, qd, qdd))

    def acceleration(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> np.ndarray:
        """Accelerations of the forward dynamics.

        Parameters
        ----------
        q, qd
            Positions (m, rad) and velocities (m/s, rad/s), (..., n_q); leading axes broadcast.
        tau
            Generalised forces (N, N m), (..., n_q).

        Returns
        -------
        numpy.ndarray
            (member, ..., n_q) in m/s^2 or rad/s^2; not finite where the mass matrix is singular.
        """
        return self._defined("acceleration", self._predicted(q, qd, None, tau))

    predict = acceleration

    def momentum(self, q: ArrayLike, qd: ArrayLike) -> np.ndarray:
        """Momentum p = dL/dqd.

        Parameters
        ----------
        q, qd
            Positions (m, rad) and velocities (m/s, rad/s), (..., n_q); leading axes broadcast.

        Returns
        -------
        numpy.ndarray
            (member, ..., n_q) in kg m/s or kg m^2/s.
        """
        return self._defined("momentum", self._predicted(q, qd))

    def mass_matrix(self, q: ArrayLike, qd: ArrayLike | None = None) -> np.ndarray:
        """Mass matrix M = d2L/dqd2.

        Parameters
        ----------
        q, qd
            Positions (m, rad) and velocities (m/s, rad/s), (..., n_q); at rest unless qd is given.

        Returns
        -------
        numpy.ndarray
            (member, ..., n_q, n_q) in kg, kg m or kg m^2.
        """
        return self._defined("mass", self._predicted(q, np.zeros_like(q, dtype=float) if qd is None else qd))

    def energies(self, q: ArrayLike, qd: ArrayLike, *, canonical: bool = True) -> EnergyValues:
        """Kinetic and potential energy, and the Hamiltonian H = p . qd - L.

        Parameters
        ----------
        q, qd
            Positions (m, rad) and velocities (m/s, rad/s), (..., n_q); leading axes broadcast.
        canonical
            L is unique only up to a constant and dF(q)/dt. True: T is 0 and least at rest, T - T(q, 0) - p(q, 0) . qd;
            otherwise T and V are as the model has them. H is defined up to a constant.

        Returns
        -------
        EnergyValues
            `kinetic`, `potential` and `hamiltonian`, each (member, ...) in J.

        Examples
        --------
        >>> import repro
        >>> data = repro.simulate("sip", samples=200, reset="random")
        >>> fitted = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares")
        >>> round(float(fitted.energies([0.0, 0.0], [2.0, 0.0]).kinetic[0]), 6)  # (m0 + m1) / 2 times 2^2
        1.6
        """
        terms = self._predicted(q, qd)
        kinetic, potential = self._defined("kinetic", terms), self._defined("potential", terms)
        hamiltonian = terms.hamiltonian(np.asarray(qd, dtype=float))
        if canonical:
            rest = self._predicted(q, np.zeros_like(qd, dtype=float))
            kinetic = kinetic - rest.kinetic - (rest.momentum * np.asarray(qd, dtype=float)).sum(-1)
            potential = potential - rest.kinetic
        return EnergyValues(kinetic, potential, hamiltonian)

    def port_form(self, q: ArrayLike, qd: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Port-Hamiltonian form, eq. (5), at x = [q; p]: xdot = (J - R) dH/dx + [0; tau].

        Parameters
        ----------
        q, qd
            Positions (m, rad) and velocities (m/s, rad/s), (..., n_q); leading axes broadcast.

        Returns
        -------
        gradient, drift : numpy.ndarray
            dH/dx and (J - R) dH/dx, (member, ..., 2 n_q) each. A model is passive where gradient . drift <= 0.

        Raises
        ------
        UserError
            For a model without energies.
        """
        if not self.model.energetic:
            raise UserError(f"{type(self.model).__name__} has no energies, so no port_form")
        arrays = np.asarray(q, dtype=float), np.asarray(qd, dtype=float)
        members = [self.model.port_values(weights, *arrays) for weights in self.weights_]
        gradient, drift = (np.stack(rows) for rows in zip(*members, strict=True))
        return gradient, drift

    def rollout(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, time_step: float | None = None) -> np.ndarray:
        """Integrate the motion under forces, by RK4.

        Parameters
        ----------
        q, qd
            The start (m, rad, and their rates), (n_q,).
        tau
            Generalised forces (N, N m), (steps, n_q), held over each step.
        time_step
            Length of a step in s; that of the data by default.

        Returns
        -------
        numpy.ndarray
            States [q, qd], (member, steps + 1, 2 n_q); not finite from where a member diverges.

        Raises
        ------
        UserError
            For arrays of other shapes.
        """
        start = np.concatenate([np.asarray(q, dtype=float), np.asarray(qd, dtype=float)])
        force = np.asarray(tau, dtype=float)
        if start.shape != (2 * self.model.n_q,) or force.shape[1:] != (self.model.n_q,):
            raise UserError(
                f"rollout: q and qd need {self.model.n_q} numbers each and tau (steps, {self.model.n_q}); "
                f"got {np.shape(q)}, {np.shape(qd)}, {force.shape}"
            )
        initial, held = (np.repeat(array[None, None], self.members, axis=0) for array in (start, force))
        step = self.data.time_step if time_step is None else time_step
        return model_motion(self.model, self.weights_, initial, held, step, self.data.angles)[:, 0]

    simulate = rollout

    def _predicted(self, *arrays: ArrayLike | None) -> Terms:
        """Quantities (member, ..., n_q) at q, qd and, where they are given, qdd and tau, (..., n_q) each."""
        n_q = self.model.n_q
        given = np.broadcast_arrays(*(np.zeros(n_q) if a is None else np.asarray(a, float) for a in arrays))
        shape = given[0].shape
        if shape[-1:] != (n_q,):
            raise UserError(f"arrays of shape {shape}: the last axis needs {n_q} coordinates")
        flat = [np.repeat(array.reshape(1, -1, n_q), self.members, axis=0) for array in given]
        terms = predict(self.model, self.weights_, *flat, *[np.zeros_like(flat[0])] * (4 - len(flat)))
        defined = {name: value for name in ALL if (value := getattr(terms, name)) is not None}
        leading = self.members, *shape[:-1]
        return Terms(**{name: value.reshape(*leading, *value.shape[2:]) for name, value in defined.items()})

    def _defined(self, name: str, terms: Terms) -> np.ndarray:
        value = getattr(terms, name)
        if value is None:
            raise UserError(f"{type(self.model).__name__} predicts no {name}")
        return np.asarray(value)
