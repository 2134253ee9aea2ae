"""The inputs of a system: their limits, and the generalised force tau = B(q) u that they make."""

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.system import System


def input_limits(system: System) -> np.ndarray:
    """The limits of |u|, (n_u,)."""
    return np.array([each.limit for each in system.inputs])


@lru_cache(maxsize=64)
def input_map(system: System) -> ca.Function:
    """q -> B(q), (n_q, n_u), for scalar and matrix expressions."""
    q = ca.SX.sym("q", system.n_q)
    matrix: Any = ca.SX(system.n_q, len(system.inputs))
    for i, row in enumerate(system.input_map(ca.vertsplit(q), ca)):
        for j, entry in enumerate(row):
            matrix[i, j] = entry
    return ca.Function("input_map", [q], [ca.densify(matrix)], {"cse": True})


def is_constant(system: System) -> bool:
    """Whether B depends on no coordinate."""
    return not input_map(system).jac_sparsity(0, 0).nnz()


def input_matrix(system: System, q: np.ndarray) -> np.ndarray:
    """B (..., n_q, n_u) at q (..., n_q)."""
    return evaluate(input_map(system), q).reshape(*q.shape, len(system.inputs))


def generalised_force(system: System, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """tau = B(q) u (..., n_q), from q (..., n_q) and u (..., n_u)."""
    return np.asarray((input_matrix(system, q) @ u[..., None])[..., 0])


def inputs_from_force(system: System, q: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """The least u (..., n_u) whose B(q) u is closest to tau (..., n_q); exact where B has full rank."""
    return np.asarray((np.linalg.pinv(input_matrix(system, q)) @ tau[..., None])[..., 0])


@lru_cache(maxsize=64)
def under_inputs(acceleration: ca.Function, system: System) -> ca.Function:
    """The acceleration (q, qd, u, parameters) -> qdd from one that takes tau in the place of u."""
    q, qd = (ca.SX.sym(name, system.n_q) for name in ("q", "qd"))
    u, parameters = ca.SX.sym("u", len(system.inputs)), ca.SX.sym("parameters", acceleration.numel_in(3))
    qdd = acceleration(q, qd, input_map(system)(q) @ u, parameters)
    return ca.Function("acceleration", [q, qd, u, parameters], [ca.densify(qdd)], {"cse": True})
