"""Models without weights: the anchor rows of every table, and the true system of any kind."""

from collections.abc import Sequence
from dataclasses import replace

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor
from repro.errors import UserError
from repro.mechanics.inputs import input_matrix
from repro.mechanics.system import System
from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions, Prepared
from repro.models.terms import Terms

NONE_DRIVEN = "is the momentum of a cyclic coordinate that an input drives, as a cart is"


class Weightless(ExpressionModel):
    """A model that has nothing to fit."""

    n_parameters = 0

    def __init__(self, n_q: int) -> None:
        self.n_q = n_q

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No weights, (member, 0)."""
        return np.zeros((len(generators), 0))


class Trivial(Weightless):
    """tau = 0, qdd = 0, no energy: what predicting nothing scores; a result that does not beat it is none."""

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """Zero, the acceleration like the force."""
        terms = super().terms(outputs, prepared)
        return replace(terms, mass=None, acceleration=terms.tau)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """No energy."""
        return EnergyExpressions(casadi.SX(0), casadi.SX(0))


class Degenerate(Weightless):
    """L = p^2 / (2 m), the true momentum of the cart alone: nothing depends on the pendulum, yet its MAE_tau is small.

    It belongs to a cyclic coordinate that an input drives, so dp/dt = f holds exactly: that row of tau is right, and
    only small parts of the others are left. A fit that stops here looks good by MAE_tau and is useless: its mass matrix
    has rank one. UserError for a system without such a coordinate.
    """

    def __init__(self, system: System) -> None:
        super().__init__(system.n_q)
        self._kinetic = system.kinetic
        found = driven_cyclic(system)
        if found is None:
            raise UserError(f"model=degenerate: {NONE_DRIVEN}; system={system.name} has none")
        self._index = found

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """No acceleration: the mass matrix is singular."""
        return replace(super().terms(outputs, prepared), mass=None)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T = p^2 / (2 m), V = 0."""
        kinetic = casadi.SX(self._kinetic(casadi.vertsplit(q), casadi.vertsplit(qd), casadi))
        momentum = casadi.gradient(kinetic, qd)[self._index]
        mass = casadi.jacobian(momentum, qd)[self._index]
        return EnergyExpressions(momentum**2 / (2 * mass), casadi.SX(0))


class Exact(Weightless):
    """T and V of the true system, the coupling of its rates within T; its friction too where `damped`."""

    def __init__(self, system: System, damped: bool = False) -> None:
        super().__init__(system.n_q)
        self.system, self.damped = system, damped

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """The true T and V."""
        at, rates = casadi.vertsplit(q), casadi.vertsplit(qd)
        kinetic = self.system.kinetic(at, rates, casadi) + self.system.coupling(at, rates, casadi)
        return EnergyExpressions(casadi.SX(kinetic), casadi.SX(self.system.potential(at, casadi)))

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """The slopes of the Rayleigh function."""
        if not self.damped:
            return super().friction(q, qd, parameters)
        dissipation = self.system.dissipation(casadi.vertsplit(q), casadi.vertsplit(qd), casadi)
        return casadi.gradient(casadi.SX(dissipation), qd)


def driven_cyclic(system: System) -> int | None:
    """Position of the first cyclic coordinate that an input drives, or None."""
    driven = np.any(input_matrix(system, system.at_rest()) != 0, axis=1)
    return next((i for i, c in enumerate(system.coordinates) if c.cyclic and driven[i]), None)
