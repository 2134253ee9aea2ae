"""A learned (or the true) Lagrangian as the CasADi functions that a predictive controller needs.

A wide network is computed in matrix operations instead of one scalar per weight.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from repro.mechanics.chain import LinkAngles
from repro.mechanics.derive import solve_symmetric
from repro.mechanics.inputs import input_map, inputs_from_force
from repro.mechanics.system import System
from repro.mechanics.system_options import Reading
from repro.models.lagrangian import Lagrangian
from repro.models.model import EnergyExpressions, Model

LARGEST_SCALAR = 2000  # weights of a model up to which scalar expressions are used


def is_wide(model: Model) -> bool:
    """Whether a model is too large for scalar expressions and has a form in matrix operations."""
    return isinstance(model, Lagrangian) and model.network is not None and model.n_parameters > LARGEST_SCALAR


@dataclass(frozen=True)
class MatrixNetwork:
    """Functions of L = N(z(q, qd)) - beta . v(q) at a state x = [q, qd], for its weights."""

    model: Lagrangian
    input_map: ca.Function

    @cached_property
    def energy(self) -> ca.Function:
        """(x, weights) -> T, V."""
        n_q = self.model.n_q
        network: Any = self.model.network  # its expression works on SX and MX
        x, weights = self._symbols()
        symbols = [ca.SX.sym(name, n_q) for name in ("q", "qd")]
        kinetic, potential = (
            ca.Function("features", symbols, [features.expression(*symbols)])
            for features in (self.model.kinetic_features, self.model.potential_features)
        )
        q, qd = x[:n_q], x[n_q:]
        kinetic_energy: Any = network.expression(weights[self.model.kinetic_slice], kinetic(q, qd))
        potential_energy: Any = ca.dot(weights[self.model.potential_slice], potential(q, qd))
        return ca.Function("energy", [x, weights], [kinetic_energy, potential_energy])

    @cached_property
    def derivative(self) -> ca.Function:
        """(x, u, weights) -> xd."""
        n_q, u = self.model.n_q, self._inputs
        x, weights = self._symbols()
        mass, rest = self._motion(x, weights)
        push = ca.mtimes(self.input_map(x[:n_q]), u) - rest
        matrix, right = ca.SX.sym("A", n_q, n_q), ca.SX.sym("b", n_q)
        solve = ca.Function("solve", [matrix, right], [solve_symmetric(matrix, right)])
        return ca.Function("derivative", [x, u, weights], [ca.vertcat(x[n_q:], solve(mass, push))])

    @cached_property
    def inverse(self) -> ca.Function:
        """(x, qdd, u, weights) -> the residual of (7b)."""
        x, weights = self._symbols()
        qdd, u = ca.MX.sym("qdd", self.model.n_q), self._inputs
        mass, rest = self._motion(x, weights)
        residual = ca.mtimes(mass, qdd) + rest - ca.mtimes(self.input_map(x[: self.model.n_q]), u)
        return ca.Function("inverse", [x, qdd, u, weights], [residual])

    def _motion(self, x: ca.MX, weights: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M, and the terms of (7b) without M qdd."""
        n_q = self.model.n_q
        kinetic, potential = self.energy(x, weights)
        gradient = ca.gradient(kinetic - potential, x)
        of_momentum = ca.jacobian(gradient[n_q:], x)
        return of_momentum[:, n_q:], ca.mtimes(of_momentum[:, :n_q], x[n_q:]) - gradient[:n_q]

    @property
    def _inputs(self) -> ca.MX:
        return ca.MX.sym("u", self.input_map.size2_out(0))

    def _symbols(self) -> tuple[ca.MX, ca.MX]:
        return ca.MX.sym("x", 2 * self.model.n_q), ca.MX.sym("w", self.model.n_parameters)


@dataclass(frozen=True)
class PredictiveModel:
    """A model with the geometry and the reading of its system; columns q, qd, qdd (n_q,), u (n_u,), and the weights.

    canonical: the gauge of the energies in the cost is fixed so that T is least at rest, T(q, 0) = 0 and
    dT/dqd(q, 0) = 0; it changes the cost only, not the motion.
    """

    model: Model
    system: System
    canonical: bool = True

    @property
    def n_q(self) -> int:
        """Number of generalised coordinates."""
        return self.system.n_q

    @property
    def n_u(self) -> int:
        """Number of inputs."""
        return len(self.system.inputs)

    def energies(self, q: ca.SX, qd: ca.SX, weights: ca.SX) -> EnergyExpressions:
        """T and V, in J, in the gauge of the cost."""
        raw = self.model.energies(q, qd, weights)
        if not self.canonical:
            return raw
        zero = ca.SX.zeros(self.n_q)
        rest, false_momentum = ca.substitute([raw.kinetic, ca.gradient(raw.kinetic, qd)], [qd], [zero])
        return EnergyExpressions(raw.kinetic - rest - ca.dot(false_momentum, qd), raw.potential - rest)

    @cached_property
    def energy(self) -> ca.Function:
        """(x, weights) -> T, V in J, x = [q, qd], in the gauge of the cost; of a wide network in that of the model."""
        if is_wide(self.model):
            return self._matrices.energy
        x, weights = ca.SX.sym("x", 2 * self.n_q), ca.SX.sym("w", self.model.n_parameters)
        energies = self.energies(x[: self.n_q], x[self.n_q :], weights)
        return ca.Function("energy", [x, weights], [energies.kinetic, energies.potential], {"cse": True})

    @cached_property
    def derivative(self) -> ca.Function:
        """(x, u, weights) -> xd."""
        if is_wide(self.model):
            return self._matrices.derivative
        x, u, weights = self._symbols
        q, qd = x[: self.n_q], x[self.n_q :]
        rate = ca.vertcat(qd, self.acceleration(q, qd, u, weights))
        return ca.Function("derivative", [x, u, weights], [rate], {"cse": True})

    @cached_property
    def inverse(self) -> ca.Function:
        """(x, qdd, u, weights) -> the residual of (7b)."""
        if is_wide(self.model):
            return self._matrices.inverse
        (x, u, weights), qdd = self._symbols, ca.SX.sym("qdd", self.n_q)
        residual = self.residual(x[: self.n_q], x[self.n_q :], qdd, u, weights)
        return ca.Function("inverse", [x, qdd, u, weights], [residual], {"cse": True})

    def rest_inputs(self, q: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The inputs (n_u,) that come closest to holding the model at rest at q (n_q,)."""
        force = self.inverse(np.append(q, np.zeros(self.n_q)), np.zeros(self.n_q), np.zeros(self.n_u), weights)
        return inputs_from_force(self.system, q, np.asarray(force).ravel())

    @property
    def _symbols(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        x, u = ca.SX.sym("x", 2 * self.n_q), ca.SX.sym("u", self.n_u)
        return x, u, ca.SX.sym("w", self.model.n_parameters)

    @cached_property
    def _matrices(self) -> MatrixNetwork:
        assert isinstance(self.model, Lagrangian)
        return MatrixNetwork(self.model, input_map(self.system))

    def potential_cost(self, potential: Any) -> Any:
        """V_cost: -V where theta = 0 is up (minimising it erects), V as printed otherwise."""
        printed = isinstance(self.system, LinkAngles) and self.system.reading == Reading.PRINTED
        return potential if printed else -potential

    def acceleration(self, q: ca.SX, qd: ca.SX, u: ca.SX, weights: ca.SX) -> ca.SX:
        """The forward dynamics, qdd."""
        return self.model.acceleration(q, qd, input_map(self.system)(q) @ u, weights)

    def residual(self, q: ca.SX, qd: ca.SX, qdd: ca.SX, u: ca.SX, weights: ca.SX) -> ca.SX:
        """The inverse model as an implicit equation, (7b): tau_hat(q, qd, qdd) - tau, zero along a motion."""
        return self.model.inverse_dynamics(q, qd, qdd, weights) - input_map(self.system)(q) @ u
