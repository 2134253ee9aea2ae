"""A learned (or the true) Lagrangian as the CasADi functions that a predictive controller needs."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from repro.control.matrix_network import MatrixNetwork, is_wide
from repro.mechanics.inputs import input_map
from repro.mechanics.link_angles import LinkAngles
from repro.mechanics.system import System
from repro.models.lagrangian import Lagrangian
from repro.models.model import EnergyExpressions, Model


@dataclass(frozen=True)
class PredictiveModel:
    """A model with the geometry and the reading of its system; columns q, qd, qdd (n_q,), scalar f, and the weights.

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
        """(x, f, weights) -> xd."""
        if is_wide(self.model):
            return self._matrices.derivative
        x, force, weights = ca.SX.sym("x", 2 * self.n_q), ca.SX.sym("f"), ca.SX.sym("w", self.model.n_parameters)
        q, qd = x[: self.n_q], x[self.n_q :]
        rate = ca.vertcat(qd, self.acceleration(q, qd, force, weights))
        return ca.Function("derivative", [x, force, weights], [rate], {"cse": True})

    @cached_property
    def inverse(self) -> ca.Function:
        """(x, qdd, f, weights) -> the residual of (7b)."""
        if is_wide(self.model):
            return self._matrices.inverse
        x, qdd, force = ca.SX.sym("x", 2 * self.n_q), ca.SX.sym("qdd", self.n_q), ca.SX.sym("f")
        weights = ca.SX.sym("w", self.model.n_parameters)
        residual = self.residual(x[: self.n_q], x[self.n_q :], qdd, force, weights)
        return ca.Function("inverse", [x, qdd, force, weights], [residual], {"cse": True})

    @cached_property
    def _matrices(self) -> MatrixNetwork:
        assert isinstance(self.model, Lagrangian)
        return MatrixNetwork(self.model, input_map(self.system))

    def potential_cost(self, potential: Any) -> Any:
        """V_cost: -V where theta = 0 is up (minimising it erects), V as printed otherwise."""
        return -potential if not isinstance(self.system, LinkAngles) or self.system.reading == "physical" else potential

    def acceleration(self, q: ca.SX, qd: ca.SX, force: ca.SX, weights: ca.SX) -> ca.SX:
        """The forward dynamics, qdd."""
        return self.model.acceleration(q, qd, input_map(self.system)(q) @ force, weights)

    def residual(self, q: ca.SX, qd: ca.SX, qdd: ca.SX, force: ca.SX, weights: ca.SX) -> ca.SX:
        """The inverse model as an implicit equation, (7b): tau_hat(q, qd, qdd) - tau, zero along a motion."""
        return self.model.inverse_dynamics(q, qd, qdd, weights) - input_map(self.system)(q) @ force
