"""The degenerate anchor row: L = p_x^2 / (2 m), no gravity, a mass matrix of rank one."""

from collections.abc import Sequence
from dataclasses import replace

import casadi
import numpy as np
from torch import Tensor

from repro.mechanics.system import System
from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions, Prepared
from repro.models.terms import Terms


class Degenerate(ExpressionModel):
    """The true cart momentum p_x alone: nothing depends on the pendulum, yet its MAE_tau is small.

    p_x belongs to a cyclic coordinate, so d/dt p_x = f holds exactly: the first row of tau is right, and only small
    parts of the others are left. A fit that stops here looks good by MAE_tau and is useless.
    """

    n_parameters = 0

    def __init__(self, system: System) -> None:
        self.n_q = system.n_q
        self._kinetic = system.kinetic

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No weights."""
        return np.zeros((len(generators), 0))

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """No acceleration: the mass matrix is singular."""
        return replace(super().terms(outputs, prepared), mass=None)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T = p_x^2 / (2 m), V = 0."""
        kinetic = casadi.SX(self._kinetic(casadi.vertsplit(q), casadi.vertsplit(qd), casadi))
        cart_momentum = casadi.gradient(kinetic, qd)[0]
        total_mass = casadi.jacobian(cart_momentum, qd)[0]
        return EnergyExpressions(cart_momentum**2 / (2 * total_mass), casadi.SX(0))
