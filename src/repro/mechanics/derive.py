"""Everything that follows from T, V and the dissipation, by differentiation."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from repro.mechanics.system import System


def euler_lagrange(functions: ca.SX, q: ca.SX, qd: ca.SX, qdd: ca.SX) -> ca.SX:
    """Euler-Lagrange operator d/dt(df/dqd) - df/dq, eq. (2), of every function f.

    functions: (n_f,); q, qd, qdd: (n_q,). Returns (n_q, n_f), a column a function.
    """
    momenta = ca.jacobian(functions, qd).T
    rate = ca.jtimes(ca.vec(momenta), ca.vertcat(q, qd), ca.vertcat(qd, qdd))
    return ca.reshape(rate, momenta.shape) - ca.jacobian(functions, q).T


BLOCK = 1024  # points evaluated together: enough to hide the call, few enough that repeated weights stay small


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
    kinetic: ca.SX, potential: ca.SX, dissipation: ca.SX, q: ca.SX, qd: ca.SX, parameters: ca.SX | None = None
) -> Dynamics:
    """Derive the dynamics of d/dt(dL/dqd) - dL/dq + dR/dqd = tau with L = T - V and R the dissipation.

    kinetic, potential, dissipation: scalars in q, qd: (n_q,) and parameters: (n_p,). T need not be quadratic in qd.
    The mass matrix d2L/dqd2 may be indefinite; where it is singular the acceleration is not finite.
    """
    free = ca.SX(0, 1) if parameters is None else parameters
    qdd, tau = ca.SX.sym("qdd", q.numel()), ca.SX.sym("tau", q.numel())
    lagrangian = kinetic - potential
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
    )


def evaluate(function: ca.Function, *arrays: np.ndarray) -> np.ndarray:
    """Evaluate a function of column vectors over arrays of points.

    arrays: (..., n_i) with leading axes that broadcast; an array (n_i,) is used at every point, and inputs of size 0 at
    the end may be left out. Returns (..., r) for a column of r, (..., r, c) for a wider matrix. ValueError where sizes
    do not fit.
    """
    given = [np.asarray(array, dtype=float) for array in arrays]
    given += [np.zeros(0)] * (function.n_in() - len(given))
    sizes = [function.numel_in(i) for i in range(function.n_in())]
    if [array.shape[-1] for array in given] != sizes:
        raise ValueError(f"{function.name()} takes vectors of {sizes}, got {[array.shape for array in given]}")
    leading = np.broadcast_shapes(*(array.shape[:-1] for array in given))
    points = math.prod(leading)
    rows, columns = function.size_out(0)
    flat = [array if array.ndim == 1 else _flatten(array, leading) for array in given]
    result = np.empty((points, columns, rows))
    whole = points - points % BLOCK
    for start in range(0, whole, BLOCK):
        _map(function, [_rows(array, start, start + BLOCK) for array in flat], result[start : start + BLOCK])
    if whole < points:
        _map(function, [_rows(array, whole, points) for array in flat], result[whole:])
    return result.reshape(*leading, rows) if columns == 1 else result.swapaxes(1, 2).reshape(*leading, rows, columns)


def _flatten(array: np.ndarray, leading: tuple[int, ...]) -> np.ndarray:
    return np.broadcast_to(array, (*leading, array.shape[-1])).reshape(-1, array.shape[-1])


def _rows(array: np.ndarray, start: int, stop: int) -> np.ndarray:
    chosen = np.broadcast_to(array, (stop - start, array.shape[-1])) if array.ndim == 1 else array[start:stop]
    return np.ascontiguousarray(chosen).reshape(-1)


@lru_cache(maxsize=64)
def _mapped(function: ca.Function, points: int) -> ca.Function:
    return function.map(points)


def _map(function: ca.Function, inputs: list[np.ndarray], result: np.ndarray) -> None:
    # C order (point, component) is the column order that CasADi reads, so nothing is copied twice
    buffer: Any
    buffer, run = _mapped(function, len(result)).buffer()
    for i, values in enumerate(inputs):
        if values.size:
            buffer.set_arg(i, values.data)
    buffer.set_res(0, result.reshape(-1).data)
    run()


def solve_symmetric(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """x of matrix x = right, for a symmetric matrix (n, n) and right (n,)."""
    # cofactors need no pivot to be non-zero, and give fewer instructions than LDL' up to size 3
    if matrix.shape[0] <= 3:
        return ca.mtimes(ca.adj(matrix), right) / ca.det(matrix)
    return ca.ldl_solve(right, *ca.ldl(matrix))
