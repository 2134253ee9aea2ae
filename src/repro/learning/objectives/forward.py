"""The error of qdd: the forward model (LNN)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.learning.objective_options import ObjectiveOptions

if TYPE_CHECKING:
    import casadi
    from torch import Tensor

    from repro.learning.symbolic import Symbols
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
        from repro.mechanics.derive import solve_symmetric

        if not model.energetic:
            return model.acceleration(s.q, s.qd, s.tau, s.parameters) - s.qdd
        error = model.inverse_dynamics(s.q, s.qd, s.qdd, s.parameters) - s.tau
        return -solve_symmetric(model.mass_matrix(s.q, s.qd, s.parameters), error)
