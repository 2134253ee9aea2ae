"""The error of tau, (7a): the inverse model (PLNN)."""

from dataclasses import dataclass
from typing import ClassVar

import casadi

from repro.codegen.lazy_torch import Tensor
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.symbolic import Symbols
from repro.models.model import Model
from repro.models.terms import Terms


@dataclass(frozen=True)
class Options(ObjectiveOptions):
    """objective=inverse has no options of its own."""

    symbolic: ClassVar[bool] = True
    linear: ClassVar[bool] = True

    def rows(self, terms: Terms, measured: dict[str, Tensor]) -> Tensor:
        """tau_hat - tau, (member, sample, n_q)."""
        error: Tensor = terms.tau - measured["tau"]
        return error

    def expression(self, model: Model, s: Symbols) -> casadi.SX:
        """tau_hat - tau, (n_q,)."""
        return model.inverse_dynamics(s.q, s.qd, s.qdd, s.parameters) - s.tau
