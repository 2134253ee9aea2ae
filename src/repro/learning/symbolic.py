"""Objectives as CasADi expressions: the same rows as `Objective.rows`, for code generation."""

from dataclasses import dataclass

import casadi

from repro.learning.objective import Objective
from repro.learning.objective_options import EnergyForm
from repro.models.model import Model

COLUMNS = ("q", "qd", "qdd", "tau", "energy", "weight")


@dataclass(frozen=True)
class Symbols:
    """One sample's symbols: q, qd, qdd, tau (n_q,), known energy, sample weight; and one member's parameters."""

    q: casadi.SX
    qd: casadi.SX
    qdd: casadi.SX
    tau: casadi.SX
    energy: casadi.SX
    weight: casadi.SX
    parameters: casadi.SX

    @property
    def inputs(self) -> list[casadi.SX]:
        """The symbols in the order of COLUMNS, then the parameters."""
        return [self.q, self.qd, self.qdd, self.tau, self.energy, self.weight, self.parameters]


def symbols(model: Model) -> Symbols:
    """Fresh symbols for a model."""
    vectors = {name: casadi.SX.sym(name, model.n_q) for name in COLUMNS[:4]}
    scalars = {name: casadi.SX.sym(name) for name in COLUMNS[4:]}
    return Symbols(**vectors, **scalars, parameters=casadi.SX.sym("parameters", model.n_parameters))


def residual(model: Model, objective: Objective, s: Symbols) -> casadi.SX:
    """Residual rows (n_rows,) of one sample, weighted; ValueError for rows that a model without energies has not."""
    equation = objective.equation
    if not model.energetic:
        if equation is None or equation.needs_energies or objective.energy_weight or objective.momentum_weight:
            raise ValueError(f"{type(model).__name__} predicts accelerations only, not the rows of {objective}")
        return casadi.sqrt(s.weight) * equation.expression(model, s)
    rows = [] if equation is None else [equation.expression(model, s)]
    momentum = model.momentum(s.q, s.qd, s.parameters)
    if objective.momentum_weight:
        transformed = model.transformed_momentum(s.q, s.qd, s.parameters)
        rows.append(objective.momentum_weight**0.5 * (transformed - momentum))
    if objective.energy_weight:
        energies = model.energies(s.q, s.qd, s.parameters)
        legendre = casadi.dot(momentum, s.qd) - (energies.kinetic - energies.potential)
        energy = energies.kinetic + energies.potential if objective.energy_form == EnergyForm.SUM else legendre
        rows.append(objective.energy_weight**0.5 * (energy - s.energy))
    return casadi.sqrt(s.weight) * casadi.vertcat(*rows)
