"""A learned (or the true) Lagrangian as the CasADi functions that a predictive controller needs.

A wide network is computed in matrix operations instead of one scalar per weight.
"""

from collections.abc import Sequence
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

    @property
    def is_wide(self) -> bool:
        """Whether the model is too large for scalar expressions and has a form in matrix operations."""
        model = self.model
        return isinstance(model, Lagrangian) and model.network is not None and model.n_parameters > LARGEST_SCALAR

    @property
    def kind(self) -> Any:
        """Scalar expressions, or matrix expressions for a wide network."""
        return ca.MX if self.is_wide else ca.SX

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
        x, _, weights = self._symbols
        parts: Sequence[Any]
        if self.is_wide:
            parts = self._matrix_energies(x, weights)
        else:
            energies = self.energies(x[: self.n_q], x[self.n_q :], weights)
            parts = energies.kinetic, energies.potential
        return ca.Function("energy", [x, weights], [*parts], self._options(2))

    @cached_property
    def derivative(self) -> ca.Function:
        """(x, u, weights) -> xd."""
        x, u, weights = self._symbols
        qdd: Any
        if self.is_wide:
            mass, rest = self._motion(x, weights)
            matrix, right = ca.SX.sym("A", self.n_q, self.n_q), ca.SX.sym("b", self.n_q)
            solve = ca.Function("solve", [matrix, right], [solve_symmetric(matrix, right)])
            qdd = solve(mass, self._force(x, u) - rest)
        else:
            qdd = self.model.acceleration(x[: self.n_q], x[self.n_q :], self._force(x, u), weights)
        return ca.Function("derivative", [x, u, weights], [ca.vertcat(x[self.n_q :], qdd)], self._options(3))

    @cached_property
    def inverse(self) -> ca.Function:
        """(x, qdd, u, weights) -> the residual of (7b): tau_hat(q, qd, qdd) - tau, zero along a motion."""
        (x, u, weights), qdd = self._symbols, self.kind.sym("qdd", self.n_q)
        force: Any
        if self.is_wide:
            mass, rest = self._motion(x, weights)
            force = ca.mtimes(mass, qdd) + rest
        else:
            force = self.model.inverse_dynamics(x[: self.n_q], x[self.n_q :], qdd, weights)
        return ca.Function("inverse", [x, qdd, u, weights], [force - self._force(x, u)], self._options(4))

    def rest_inputs(self, q: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The inputs (n_u,) that come closest to holding the model at rest at q (n_q,)."""
        force = self.inverse(np.append(q, np.zeros(self.n_q)), np.zeros(self.n_q), np.zeros(self.n_u), weights)
        return inputs_from_force(self.system, q, np.asarray(force).ravel())

    def potential_cost(self, potential: Any) -> Any:
        """V_cost: -V where theta = 0 is up (minimising it erects), V as printed otherwise."""
        printed = isinstance(self.system, LinkAngles) and self.system.reading == Reading.PRINTED
        return potential if printed else -potential

    def _options(self, n_inputs: int) -> dict[str, Any]:
        """Of a function whose last input is the weights, by which a wide one is never differentiated."""
        differentiable = [True] * (n_inputs - 1) + [False]
        return {"is_diff_in": differentiable} if self.is_wide else {"cse": True}

    def _force(self, x: Any, u: Any) -> Any:
        """tau = B(q) u."""
        return ca.mtimes(input_map(self.system)(x[: self.n_q]), u)

    def _matrix_energies(self, x: ca.MX, weights: ca.MX) -> tuple[ca.MX, ca.MX]:
        """T = N(z(q, qd)) and V = beta . v(q) of a wide network."""
        assert isinstance(self.model, Lagrangian)
        network: Any = self.model.network  # its expression works on SX and MX
        symbols = [ca.SX.sym(name, self.n_q) for name in ("q", "qd")]
        q, qd = x[: self.n_q], x[self.n_q :]
        kinetic, potential = (
            ca.Function("features", symbols, [features.expression(*symbols)])(q, qd)
            for features in (self.model.kinetic_features, self.model.potential_features)
        )
        kinetic_energy: Any = network.expression(weights[self.model.kinetic_slice], kinetic)
        potential_energy: Any = ca.dot(weights[self.model.potential_slice], potential)
        return kinetic_energy, potential_energy

    def _motion(self, x: ca.MX, weights: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M of a wide network, and the terms of (7b) without M qdd."""
        kinetic, potential = self.energy(x, weights)
        gradient = ca.gradient(kinetic - potential, x)
        of_momentum = ca.jacobian(gradient[self.n_q :], x)
        rest = ca.mtimes(of_momentum[:, : self.n_q], x[self.n_q :]) - gradient[: self.n_q]
        return of_momentum[:, self.n_q :], rest

    @property
    def _symbols(self) -> tuple[Any, Any, Any]:
        """x, u and the weights, scalar or as matrices."""
        sizes = {"x": 2 * self.n_q, "u": self.n_u, "w": self.model.n_parameters}
        x, u, weights = (self.kind.sym(name, size) for name, size in sizes.items())
        return x, u, weights
