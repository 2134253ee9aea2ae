"""The error of a model's own implicit equation, which is linear in its weights (SINDy, SINDy-PI)."""

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
    """objective=implicit has no options of its own."""

    symbolic: ClassVar[bool] = True
    linear: ClassVar[bool] = True
    needs_energies: ClassVar[bool] = False
    needs_force: ClassVar[bool] = False
    needs_implicit_form: ClassVar[bool] = True

    def rows(self, terms: Terms, measured: dict[str, Tensor]) -> Tensor:
        """Left side minus right side, (member, sample, n_q)."""
        error: Tensor = terms.implicit_error
        return error

    def expression(self, model: Model, s: Symbols) -> casadi.SX:
        """The same, (n_q,)."""
        return model.implicit_error(s.q, s.qd, s.qdd, s.tau, s.parameters)
