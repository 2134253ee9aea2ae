"""The accelerations of a model with their first and second derivatives, by the implicit function theorem on (7b).

With r(z, qdd) = tau_hat - tau = 0 and z = [q, qd, u]:

    dqdd/dz = -M^-1 dr/dz
    d2(lambda . qdd)/dz2 = -E' d2(mu . r)/d(z, qdd)2 E,   mu = M^-T lambda,  E = [I; dqdd/dz],

so that no inverse is ever differentiated (Griewank & Walther, Evaluating Derivatives, 2008, ch. 15).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from math import factorial, prod

import casadi as ca

from repro.codegen.array_evaluation import column_function
from repro.control.predictive_model import PredictiveModel
from repro.mechanics.inputs import input_map

THIRD = 3  # derivatives of M and V that second derivatives of qdd need


@dataclass(frozen=True)
class Rate:
    """Scalar functions of z = [q, qd, u] (n_z,) and the weights w; every result is one column.

    value     (z, w) -> qdd
    jacobian  (z, w) -> [qdd | dqdd/dz by rows]
    hessian   (z, w, j, lambda) -> d2(lambda . qdd)/dz2, all n_z^2 entries; j is the result of `jacobian`
    """

    model: PredictiveModel

    @property
    def n_q(self) -> int:
        """Number of accelerations."""
        return self.model.n_q

    @cached_property
    def value(self) -> ca.Function:
        """qdd."""
        z, w = self._symbols
        return column_function("rate_value", [z, w], self._motion(z, w)[0])

    @cached_property
    def jacobian(self) -> ca.Function:
        """qdd and its Jacobian."""
        z, w = self._symbols
        acceleration, inverse = self._motion(z, w)
        _, _, of_residual, _ = self._residual(z, acceleration, ca.SX.zeros(self.n_q), w)
        return column_function("rate_jacobian", [z, w], acceleration, ca.vec(-(inverse @ of_residual).T))

    @cached_property
    def hessian(self) -> ca.Function:
        """The Hessian of a combination of qdd."""
        z, w = self._symbols
        n_z = z.numel()
        jacobian, multipliers = ca.SX.sym("j", self.n_q * (1 + n_z)), ca.SX.sym("lambda", self.n_q)
        _, inverse = self._motion(z, w)
        _, _, _, of_residual = self._residual(z, jacobian[: self.n_q], inverse.T @ multipliers, w)
        extended = ca.vertcat(ca.SX.eye(n_z), ca.reshape(jacobian[self.n_q :], n_z, self.n_q).T)
        hessian = -(extended.T @ of_residual @ extended)
        return column_function("rate_hessian", [z, w, jacobian, multipliers], ca.vec(hessian))

    @property
    def _symbols(self) -> tuple[ca.SX, ca.SX]:
        return ca.SX.sym("z", 2 * self.n_q + self.model.n_u), ca.SX.sym("w", self.model.model.n_parameters)

    def _motion(self, z: ca.SX, w: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return qdd and M^-1."""
        rest = ca.SX.zeros(self.n_q)
        mass, force, _, _ = self._residual(z, rest, rest, w)
        inverse = ca.inv_minor(mass)
        return -(inverse @ force), inverse

    @cached_property
    def _residual(self) -> ca.Function:
        """(z, qdd, mu, w) -> M, r at qdd = 0, dr/dz and d2(mu . r)/d(z, qdd)2."""
        n_q = self.n_q
        z, w = self._symbols
        q, qd, u = z[:n_q], z[n_q : 2 * n_q], z[2 * n_q :]
        qdd, mu = ca.SX.sym("qdd", n_q), ca.SX.sym("mu", n_q)
        taylor = _quadratic_energy(self.model, q, qd, w)
        tau = input_map(self.model.system)(q) @ u
        everything = ca.vertcat(z, qdd)
        if taylor is None:
            parts = _derivatives(self.model.model.inverse_dynamics(q, qd, qdd, w) - tau, z, qdd, mu)
        else:
            active, entries = taylor
            jets = _jets(entries, q, active)
            # the energies enter through their Taylor polynomial at q alone, whose coefficients are computed once
            coefficients = ca.SX.sym("jets", entries.numel(), len(jets))
            expansion = _polynomial(coefficients, q, active)
            at_zero = _derivatives(_inertial(expansion, q, qd, qdd), z, qdd, mu)
            at_zero = ca.substitute(list(at_zero), [q], [ca.SX.zeros(n_q)])
            expanded = ca.Function("conservative", [everything, mu, coefficients], at_zero)
            conservative = expanded(everything, mu, ca.horzcat(*jets))
            other = _derivatives(self.model.model.friction(q, qd, w) - tau, z, qdd, mu)
            parts = [a + b for a, b in zip(conservative, other, strict=True)]
        return ca.Function("residual", [z, qdd, mu, w], list(parts), {"cse": True})


def _derivatives(residual: ca.SX, z: ca.SX, qdd: ca.SX, mu: ca.SX) -> list[ca.SX]:
    """Return M, r at qdd = 0, dr/dz and d2(mu . r)/d(z, qdd)2."""
    everything = ca.vertcat(z, qdd)
    return [
        ca.densify(part)
        for part in (
            ca.jacobian(residual, qdd),
            ca.substitute(residual, qdd, ca.SX.zeros(qdd.numel())),
            ca.jacobian(residual, z),
            ca.hessian(ca.dot(mu, residual), everything)[0],
        )
    ]


def _quadratic_energy(model: PredictiveModel, q: ca.SX, qd: ca.SX, w: ca.SX) -> tuple[list[int], ca.SX] | None:
    """The upper triangle of M(q), and V(q), with the coordinates that they depend on, if T = qd' M(q) qd / 2."""
    energies = model.model.energies(q, qd, w)
    momentum = ca.gradient(energies.kinetic, qd)
    mass = ca.jacobian(momentum, qd)
    rest = ca.substitute(ca.vertcat(momentum, energies.kinetic), qd, ca.SX.zeros(model.n_q))
    if ca.depends_on(mass, qd) or ca.depends_on(energies.potential, qd) or not ca.simplify(rest).is_zero():
        return None
    upper = [mass[i, j] for i in range(model.n_q) for j in range(i, model.n_q)]
    entries = ca.densify(ca.vertcat(*upper, energies.potential))
    return [k for k in range(model.n_q) if ca.depends_on(entries, q[k])], entries


def _orders(count: int) -> list[tuple[int, ...]]:
    """The variables of every partial derivative up to the third order, the value itself first."""
    return [indices for order in range(THIRD + 1) for indices in combinations_with_replacement(range(count), order)]


def _jets(entries: ca.SX, q: ca.SX, active: Sequence[int]) -> list[ca.SX]:
    """The partial derivatives up to the third order, one column each."""
    derivatives: dict[tuple[int, ...], ca.SX] = {(): entries}
    for indices in _orders(len(active))[1:]:
        derivatives[indices] = ca.densify(ca.jacobian(derivatives[indices[:-1]], q[active[indices[-1]]]))
    return list(derivatives.values())


def _polynomial(jets: ca.SX, q: ca.SX, active: Sequence[int]) -> ca.SX:
    """The Taylor polynomial of these derivatives around q = 0."""
    powers = [
        prod(q[active[i]] for i in indices) / prod(factorial(indices.count(i)) for i in set(indices))
        for indices in _orders(len(active))
    ]
    return jets @ ca.vertcat(*powers)


def _inertial(entries: ca.SX, q: ca.SX, qd: ca.SX, qdd: ca.SX) -> ca.SX:
    """M qdd + Mdot qd - d/dq (qd' M qd / 2) + dV/dq from the upper triangle of M, and V."""
    n_q = q.numel()
    mass = ca.SX(n_q, n_q)
    pairs = [(i, j) for i in range(n_q) for j in range(i, n_q)]
    for number, (i, j) in enumerate(pairs):
        mass[i, j] = mass[j, i] = entries[number]
    momentum = mass @ qd
    lagrangian = 0.5 * ca.dot(qd, momentum) - entries[len(pairs)]
    return mass @ qdd + ca.jtimes(momentum, q, qd) - ca.gradient(lagrangian, q)
