"""Objectives as CasADi expressions: the same rows as `Objective.rows`, for code generation."""

from dataclasses import dataclass
from typing import assert_never

import casadi

from repro.learning.objective import Objective
from repro.learning.objective_options import EnergyForm, Equation
from repro.mechanics.derive import solve_symmetric
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
    if not model.energetic:
        if objective.equation != Equation.FORWARD or objective.energy_weight or objective.momentum_weight:
            raise ValueError(f"{type(model).__name__} predicts accelerations only, not the rows of {objective}")
        return casadi.sqrt(s.weight) * (model.acceleration(s.q, s.qd, s.tau, s.parameters) - s.qdd)
    energies = model.energies(s.q, s.qd, s.parameters)
    lagrangian = energies.kinetic - energies.potential
    momentum = casadi.gradient(lagrangian, s.qd)
    rows = []
    match objective.equation:
        case Equation.INVERSE | Equation.BALANCE | Equation.PATH:
            rows.append(model.inverse_dynamics(s.q, s.qd, s.qdd, s.parameters) - s.tau)
        case Equation.FORWARD:
            error = model.inverse_dynamics(s.q, s.qd, s.qdd, s.parameters) - s.tau
            rows.append(-solve_symmetric(casadi.jacobian(momentum, s.qd), error))
        case Equation.PORT:
            rows.append(model.port_error(s.q, s.qd, s.qdd, s.tau, s.parameters))
        case None:
            pass
        case _:
            assert_never(objective.equation)
    if objective.momentum_weight:
        transformed = model.transformed_momentum(s.q, s.qd, s.parameters)
        rows.append(objective.momentum_weight**0.5 * (transformed - momentum))
    if objective.energy_weight:
        legendre = casadi.dot(momentum, s.qd) - lagrangian
        energy = energies.kinetic + energies.potential if objective.energy_form == EnergyForm.SUM else legendre
        rows.append(objective.energy_weight**0.5 * (energy - s.energy))
    return casadi.sqrt(s.weight) * casadi.vertcat(*rows)
