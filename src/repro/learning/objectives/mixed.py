"""The errors of tau, of qdd and of the power together, as in DeLaN with energy (Lutter and Peters 2023)."""

from dataclasses import dataclass
from typing import ClassVar

import casadi

from repro.codegen.lazy_torch import Tensor, torch
from repro.learning.objectives import forward, inverse
from repro.learning.symbolic import Symbols
from repro.models.model import Model
from repro.models.terms import Terms
from repro.plugins.options import NotNegative


@dataclass(frozen=True)
class Options(inverse.Options):
    """Options of objective=mixed; forward_weight, power_weight: of the squared errors of qdd and of the power."""

    linear: ClassVar[bool] = False
    needs_mass: ClassVar[bool] = True

    forward_weight: NotNegative = 1.0
    power_weight: NotNegative = 1.0

    def rows(self, terms: Terms, measured: dict[str, Tensor]) -> Tensor:
        """[tau_hat - tau, qdd_hat - qdd, (tau_hat - tau) . qd], (member, sample, 2 n_q + 1)."""
        force = super().rows(terms, measured)
        acceleration = terms.acceleration_error(measured["qdd"], measured["tau"])
        power = (force * measured["qd"]).sum(-1, keepdim=True)
        return torch.cat([force, self.forward_weight**0.5 * acceleration, self.power_weight**0.5 * power], dim=-1)

    def expression(self, model: Model, s: Symbols) -> casadi.SX:
        """The same, (2 n_q + 1,)."""
        force, acceleration = super().expression(model, s), forward.Options().expression(model, s)
        power = casadi.dot(force, s.qd)
        return casadi.vertcat(force, self.forward_weight**0.5 * acceleration, self.power_weight**0.5 * power)
