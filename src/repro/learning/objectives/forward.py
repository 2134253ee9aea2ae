"""The error of qdd: the forward model (LNN)."""

from dataclasses import dataclass
from typing import ClassVar

import casadi

from repro.codegen.lazy_torch import Tensor
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.symbolic import Symbols
from repro.mechanics.derive import solve_symmetric
from repro.models.model import Model
from repro.models.terms import Terms


@dataclass(frozen=True)
class Options(ObjectiveOptions):
    """objective=forward has no options of its own."""

    symbolic: ClassVar[bool] = True
    needs_energies: ClassVar[bool] = False
    needs_mass: ClassVar[bool] = True
    needs_force: ClassVar[bool] = False

    def rows(self, terms: Terms, measured: dict[str, Tensor]) -> Tensor:
        """qdd_hat - qdd, (member, sample, n_q); not finite where M_hat is singular."""
        return terms.acceleration_error(measured["qdd"], measured["tau"])

    def expression(self, model: Model, s: Symbols) -> casadi.SX:
        """qdd_hat - qdd, (n_q,)."""
        if not model.energetic:
            return model.acceleration(s.q, s.qd, s.tau, s.parameters) - s.qdd
        error = model.inverse_dynamics(s.q, s.qd, s.qdd, s.parameters) - s.tau
        return -solve_symmetric(model.mass_matrix(s.q, s.qd, s.parameters), error)
