"""The trivial anchor row: tau = 0, qdd = 0, no energy."""

from collections.abc import Sequence
from dataclasses import replace

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor
from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions, Prepared
from repro.models.terms import Terms


class Trivial(ExpressionModel):
    """What predicting nothing scores; a result that does not beat it is none."""

    n_parameters = 0

    def __init__(self, n_q: int) -> None:
        self.n_q = n_q

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No weights."""
        return np.zeros((len(generators), 0))

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """Zero, the acceleration like the force."""
        terms = super().terms(outputs, prepared)
        return replace(terms, mass=None, acceleration=terms.tau)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """No energy."""
        return EnergyExpressions(casadi.SX(0), casadi.SX(0))
