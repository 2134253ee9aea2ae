"""The true system of any kind as a model without weights."""

from collections.abc import Sequence

import casadi
import numpy as np

from repro.mechanics.system import System
from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions


class Exact(ExpressionModel):
    """T and V of the system, the coupling of its rates within T; its friction too where `damped`."""

    n_parameters = 0

    def __init__(self, system: System, damped: bool = False) -> None:
        self.n_q, self.system, self.damped = system.n_q, system, damped

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No weights."""
        return np.zeros((len(generators), 0))

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
