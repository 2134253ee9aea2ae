"""The degenerate anchor row: L = p_x^2 / (2 m), no gravity, a mass matrix of rank one."""

from collections.abc import Sequence

import casadi
import numpy as np
import torch
from torch import Tensor

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.system import System
from repro.models.model import EnergyExpressions, Model, Prepared
from repro.models.terms import Terms


class Degenerate(Model):
    """The true cart momentum p_x alone: it knows nothing of the pendulum, yet its MAE_tau is small.

    p_x belongs to a cyclic coordinate, so d/dt p_x = f holds exactly: the first row of tau is right, and only small
    parts of the others are left. A fit that stops here looks good by MAE_tau and is useless.
    """

    n_parameters = 0

    def __init__(self, system: System) -> None:
        self.n_q = system.n_q
        self._kinetic = system.kinetic
        q, qd, qdd = (casadi.SX.sym(name, self.n_q) for name in ("q", "qd", "qdd"))
        kinetic = self.energies(q, qd, casadi.SX(0, 1)).kinetic
        momentum = casadi.gradient(kinetic, qd)
        tau = casadi.jtimes(momentum, casadi.vertcat(q, qd), casadi.vertcat(qd, qdd)) - casadi.gradient(kinetic, q)
        rows = casadi.vertcat(tau, momentum, kinetic)
        self._function = casadi.Function("degenerate", [q, qd, qdd], [casadi.densify(rows)])

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No weights."""
        return np.zeros((len(generators), 0))

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """tau, momentum and T of the degenerate Lagrangian, (..., 2 n_q + 1)."""
        return {"rows": evaluate(self._function, q, qd, qdd)}

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """Nothing depends on weights."""
        return []

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """No acceleration: the mass matrix is singular."""
        tau, momentum, kinetic = torch.split(prepared["rows"], [self.n_q, self.n_q, 1], dim=-1)
        kinetic = kinetic.squeeze(-1)
        return Terms(tau=tau, momentum=momentum, kinetic=kinetic, potential=torch.zeros_like(kinetic))

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """No weights, no gradients."""
        return torch.zeros(0)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T = p_x^2 / (2 m), V = 0."""
        kinetic = casadi.SX(self._kinetic(casadi.vertsplit(q), casadi.vertsplit(qd), casadi))
        cart_momentum = casadi.gradient(kinetic, qd)[0]
        total_mass = casadi.jacobian(cart_momentum, qd)[0]
        return EnergyExpressions(cart_momentum**2 / (2 * total_mass), casadi.SX(0))
