"""The symbols of one sample, of which objectives make CasADi expressions for code generation."""

from dataclasses import dataclass

import casadi

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
