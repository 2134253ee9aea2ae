"""The error of both rows of eq. (12b): the rates of q and of p."""

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
    """objective=port has no options of its own."""

    symbolic: ClassVar[bool] = True
    needs_port_form: ClassVar[bool] = True

    def rows(self, terms: Terms, measured: dict[str, Tensor]) -> Tensor:
        """Motion of the model minus that of the data, (member, sample, 2 n_q)."""
        error: Tensor = terms.port_error
        return error

    def expression(self, model: Model, s: Symbols) -> casadi.SX:
        """The same, (2 n_q,)."""
        return model.port_error(s.q, s.qd, s.qdd, s.tau, s.parameters)
