"""Everything that follows from T, V and the dissipation, by differentiation."""

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.system import System


def euler_lagrange(functions: ca.SX, q: ca.SX, qd: ca.SX, qdd: ca.SX) -> ca.SX:
    """Euler-Lagrange operator d/dt(df/dqd) - df/dq, eq. (2), of every function f.

    functions: (n_f,); q, qd, qdd: (n_q,). Returns (n_q, n_f), a column a function.
    """
    momenta = ca.jacobian(functions, qd).T
    rate = ca.jtimes(ca.vec(momenta), ca.vertcat(q, qd), ca.vertcat(qd, qdd))
    return ca.reshape(rate, momenta.shape) - ca.jacobian(functions, q).T


@dataclass(frozen=True)
class Dynamics:
    """Functions derived from one set of energies; all take column vectors, the last one being `parameters`.

    acceleration(q, qd, tau, .) and inverse(q, qd, qdd, .) -> (n_q,), the others take (q, qd, .): momentum (n_q,),
    mass_matrix (n_q, n_q), and the scalars kinetic, potential, lagrangian, hamiltonian (J) and dissipated_power (W).
    """

    n_q: int
    acceleration: ca.Function
    inverse: ca.Function
    momentum: ca.Function
    mass_matrix: ca.Function
    kinetic: ca.Function
    potential: ca.Function
    lagrangian: ca.Function
    hamiltonian: ca.Function
    dissipated_power: ca.Function


def derive(
    kinetic: ca.SX,
    potential: ca.SX,
    dissipation: ca.SX,
    q: ca.SX,
    qd: ca.SX,
    parameters: ca.SX | None = None,
    coupling: ca.SX | None = None,
) -> Dynamics:
    """Derive the dynamics of d/dt(dL/dqd) - dL/dq + dR/dqd = tau with L = T + G - V, R the dissipation, G the coupling.

    All are scalars in q, qd: (n_q,) and parameters: (n_p,); G is linear in qd. T need not be quadratic in qd.
    The mass matrix d2L/dqd2 may be indefinite; where it is singular the acceleration is not finite.
    """
    free = ca.SX(0, 1) if parameters is None else parameters
    qdd, tau = ca.SX.sym("qdd", q.numel()), ca.SX.sym("tau", q.numel())
    lagrangian = kinetic - potential if coupling is None else kinetic + coupling - potential
    momentum = ca.gradient(lagrangian, qd)
    mass = ca.jacobian(momentum, qd)
    friction = ca.gradient(dissipation, qd)
    inverse = euler_lagrange(lagrangian, q, qd, qdd) + friction
    acceleration = solve_symmetric(mass, tau - ca.substitute(inverse, qdd, ca.SX.zeros(q.numel())))

    def function(name: str, expression: ca.SX, *third: ca.SX) -> ca.Function:
        return ca.Function(name, [q, qd, *third, free], [ca.densify(expression)], {"cse": True})

    return Dynamics(
        n_q=q.numel(),
        acceleration=function("acceleration", acceleration, tau),
        inverse=function("inverse", inverse, qdd),
        momentum=function("momentum", momentum),
        mass_matrix=function("mass_matrix", mass),
        kinetic=function("kinetic", kinetic),
        potential=function("potential", potential),
        lagrangian=function("lagrangian", lagrangian),
        hamiltonian=function("hamiltonian", ca.dot(momentum, qd) - lagrangian),
        dissipated_power=function("dissipated_power", ca.dot(qd, friction)),
    )


@lru_cache(maxsize=64)
def dynamics_of(system: System) -> Dynamics:
    """Derive the dynamics of a true system (kept, so that asking again costs nothing)."""
    q, qd = ca.SX.sym("q", system.n_q), ca.SX.sym("qd", system.n_q)
    components, rates = ca.vertsplit(q), ca.vertsplit(qd)
    return derive(
        ca.SX(system.kinetic(components, rates, ca)),
        ca.SX(system.potential(components, ca)),
        ca.SX(system.dissipation(components, rates, ca)),
        q,
        qd,
        coupling=ca.SX(system.coupling(components, rates, ca)),
    )


def energies_along(system: System, states: np.ndarray) -> dict[str, np.ndarray]:
    """T, V and H = T + V of a true system along states (..., 2 n_q), each (...,) in J."""
    dynamics, (q, qd) = dynamics_of(system), np.split(states, 2, axis=-1)
    kinetic, potential = (evaluate(function, q, qd)[..., 0] for function in (dynamics.kinetic, dynamics.potential))
    return {"T": kinetic, "V": potential, "H": kinetic + potential}


def solve_symmetric(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """x of matrix x = right, for a symmetric matrix (n, n) and right (n,)."""
    # cofactors need no pivot to be non-zero, and give fewer instructions than LDL' up to size 3
    if matrix.shape[0] <= 3:
        return ca.mtimes(ca.adj(matrix), right) / ca.det(matrix)
    return ca.ldl_solve(right, *ca.ldl(matrix))
