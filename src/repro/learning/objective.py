"""Losses (7a), (8) and l_H as rows of residuals: the loss of a sample is the weighted sum of its squared rows."""

from dataclasses import dataclass

import casadi

from repro.codegen.lazy_torch import Tensor, torch
from repro.learning.objective_options import EnergyForm, ObjectiveOptions
from repro.learning.objectives import inverse
from repro.learning.symbolic import Symbols
from repro.models.model import Model
from repro.models.terms import Terms

INVERSE = inverse.Options()


@dataclass(frozen=True)
class Objective:
    """What is minimised on one dataset.

    equation: None has no row of an equation of motion. energy_weight: of the squared energy error where the energy is
    known (III-A.1), with H_hat the `legendre` transform p.qd - L or the printed `sum` T + V.
    """

    equation: ObjectiveOptions | None = INVERSE
    energy_weight: float = 0.0
    energy_form: EnergyForm = EnergyForm.LEGENDRE

    @property
    def mass(self) -> bool:
        """Whether the mass matrix is needed."""
        return self.equation is not None and self.equation.needs_mass

    @property
    def symbolic(self) -> bool:
        """Whether the rows are expressions too."""
        return self.equation is None or self.equation.symbolic

    @property
    def momentum_weight(self) -> float:
        """The weight of Omega_tran, eq. (8)."""
        return 0.0 if self.equation is None else self.equation.momentum_weight

    def rows(self, terms: Terms, measured: dict[str, Tensor]) -> Tensor:
        """Weighted residual rows (member, sample, row); measured: qd, qdd, tau (member, sample, n_q) and energy."""
        rows = [] if self.equation is None else [self.equation.rows(terms, measured)]
        if self.momentum_weight:
            rows.append(self.momentum_weight**0.5 * (terms.transformed_momentum - terms.momentum))
        if self.energy_weight:
            energy = terms.energy_sum if self.energy_form == EnergyForm.SUM else terms.hamiltonian(measured["qd"])
            rows.append(self.energy_weight**0.5 * (energy - measured["energy"]).unsqueeze(-1))
        return torch.cat(rows, dim=-1)

    def expression(self, model: Model, s: Symbols) -> casadi.SX:
        """The same rows (row,) of one sample in CasADi; ValueError for rows that a model without energies has not."""
        equation = self.equation
        if not model.energetic:
            if equation is None or equation.needs_energies or self.energy_weight or self.momentum_weight:
                raise ValueError(f"{type(model).__name__} predicts accelerations only, not the rows of {self}")
            return casadi.sqrt(s.weight) * equation.expression(model, s)
        rows = [] if equation is None else [equation.expression(model, s)]
        momentum = model.momentum(s.q, s.qd, s.parameters)
        if self.momentum_weight:
            transformed = model.transformed_momentum(s.q, s.qd, s.parameters)
            rows.append(self.momentum_weight**0.5 * (transformed - momentum))
        if self.energy_weight:
            energies = model.energies(s.q, s.qd, s.parameters)
            legendre = casadi.dot(momentum, s.qd) - (energies.kinetic - energies.potential)
            energy = energies.kinetic + energies.potential if self.energy_form == EnergyForm.SUM else legendre
            rows.append(self.energy_weight**0.5 * (energy - s.energy))
        return casadi.sqrt(s.weight) * casadi.vertcat(*rows)
