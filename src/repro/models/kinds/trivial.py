"""The trivial anchor row: tau = 0, qdd = 0, no energy."""

from dataclasses import dataclass, replace
from typing import ClassVar

import casadi

from repro.codegen.lazy_torch import Tensor
from repro.models.context import Context
from repro.models.expression import Weightless
from repro.models.model import EnergyExpressions, Model, Prepared
from repro.models.model_options import ModelOptions
from repro.models.terms import Terms


@dataclass(frozen=True)
class Options(ModelOptions):
    """model=trivial has no options."""

    fitted: ClassVar[bool] = False
    controllable: ClassVar[bool] = False


class Trivial(Weightless):
    """tau = 0, qdd = 0, no energy: what predicting nothing scores; a result that does not beat it is none."""

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """Zero, the acceleration like the force."""
        terms = super().terms(outputs, prepared)
        return replace(terms, mass=None, acceleration=terms.tau)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """No energy."""
        return EnergyExpressions(casadi.SX(0), casadi.SX(0))


def build(context: Context, options: Options) -> Model:
    """The model that predicts zeros."""
    return Trivial(context.n_q)
