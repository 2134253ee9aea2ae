"""A Lagrangian whose T is a wide network, in matrix operations instead of one scalar per weight."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from repro.mechanics.derive import solve_symmetric
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model

LARGEST_SCALAR = 2000  # weights of a model up to which scalar expressions are used


def is_wide(model: Model) -> bool:
    """Whether a model is too large for scalar expressions and has a form in matrix operations."""
    return isinstance(model, Lagrangian) and model.network is not None and model.n_parameters > LARGEST_SCALAR


@dataclass(frozen=True)
class MatrixNetwork:
    """Functions of L = N(z(q, qd)) - beta . v(q) at a state x = [q, qd], for its weights."""

    model: Lagrangian
    input_map: ca.Function

    @cached_property
    def energy(self) -> ca.Function:
        """(x, weights) -> T, V."""
        n_q = self.model.n_q
        network: Any = self.model.network  # its expression works on SX and MX
        x, weights = self._symbols()
        symbols = [ca.SX.sym(name, n_q) for name in ("q", "qd")]
        kinetic, potential = (
            ca.Function("features", symbols, [features.expression(*symbols)])
            for features in (self.model.kinetic_features, self.model.potential_features)
        )
        q, qd = x[:n_q], x[n_q:]
        kinetic_energy: Any = network.expression(weights[self.model.kinetic_slice], kinetic(q, qd))
        potential_energy: Any = ca.dot(weights[self.model.potential_slice], potential(q, qd))
        return ca.Function("energy", [x, weights], [kinetic_energy, potential_energy])

    @cached_property
    def derivative(self) -> ca.Function:
        """(x, u, weights) -> xd."""
        x, weights = self._symbols()
        u = self._inputs
        mass, rest = self._motion(x, weights)
        push = ca.mtimes(self.input_map(x[: self.model.n_q]), u) - rest
        return ca.Function(
            "derivative", [x, u, weights], [ca.vertcat(x[self.model.n_q :], _solver(self.model.n_q)(mass, push))]
        )

    @cached_property
    def inverse(self) -> ca.Function:
        """(x, qdd, u, weights) -> the residual of (7b)."""
        x, weights = self._symbols()
        qdd, u = ca.MX.sym("qdd", self.model.n_q), self._inputs
        mass, rest = self._motion(x, weights)
        residual = ca.mtimes(mass, qdd) + rest - ca.mtimes(self.input_map(x[: self.model.n_q]), u)
        return ca.Function("inverse", [x, qdd, u, weights], [residual])

    def _motion(self, x: ca.MX, weights: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M, and the terms of (7b) without M qdd."""
        n_q = self.model.n_q
        kinetic, potential = self.energy(x, weights)
        gradient = ca.gradient(kinetic - potential, x)
        of_momentum = ca.jacobian(gradient[n_q:], x)
        return of_momentum[:, n_q:], ca.mtimes(of_momentum[:, :n_q], x[n_q:]) - gradient[:n_q]

    @property
    def _inputs(self) -> ca.MX:
        return ca.MX.sym("u", self.input_map.size2_out(0))

    def _symbols(self) -> tuple[ca.MX, ca.MX]:
        return ca.MX.sym("x", 2 * self.model.n_q), ca.MX.sym("w", self.model.n_parameters)


def _solver(n: int) -> ca.Function:
    """(A, b) -> x of A x = b for a small matrix, by cofactors: no pivot needs to be non-zero."""
    matrix, right = ca.SX.sym("A", n, n), ca.SX.sym("b", n)
    return ca.Function("solve", [matrix, right], [solve_symmetric(matrix, right)])
