"""How well friction is identified: the learned damping matrix C = d(friction)/dqd against the true one."""

from collections.abc import Iterator
from functools import lru_cache

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.data.dataset import Dataset
from repro.evaluation.pointwise import MetricValues
from repro.mechanics.coordinate import joint_rates
from repro.mechanics.system import System
from repro.models.model import Model

STATES = 2000  # test samples over which C is averaged


def damping_errors(
    model: Model, parameters: np.ndarray, part: Dataset, system: System, split: str
) -> Iterator[MetricValues]:
    """Relative errors of C over the test states, whole (Frobenius) and per joint, and its least eigenvalue.

    Nothing for a model without friction, or a system without damping. The coefficient of a joint is C along the motion
    that turns this joint alone: all rates from this joint outwards are equal.
    """
    if not any(system.damping) or model.not_symbolic is not None or not _has_friction(model):
        return
    q, qd = (array[:, :STATES] for array in (part.q, part.qd))
    members = zip(q, qd, np.asarray(parameters, dtype=float), strict=True)
    shape = (*q.shape, system.n_q)
    learned = np.stack([evaluate(_learned(model), *member) for member in members]).reshape(shape)
    true = evaluate(_true(system), q, qd).reshape(shape)
    symmetric = (learned + learned.swapaxes(-2, -1)) / 2
    if system.is_coupled:  # the other part of a general C is that coupling
        learned = symmetric
    error = np.linalg.norm(learned - true, axis=(-2, -1)).mean(1) / np.linalg.norm(true, axis=(-2, -1)).mean(1)
    yield MetricValues(split, "damping_error", error, "1")
    joints = np.linalg.inv(joint_rates(system.n_q, system.jointed))  # columns: one joint alone turns
    ours, theirs = (np.einsum("ic,mnij,jc->mnc", joints, matrix, joints) for matrix in (learned, true))
    for joint in np.flatnonzero(system.damping):
        gap = np.abs(ours[..., joint] - theirs[..., joint]).mean(1) / theirs[..., joint].mean(1)
        yield MetricValues(split, f"damping_error[{joint}]", gap, "1")
    yield MetricValues(split, "min_eig_C", np.linalg.eigvalsh(symmetric).min((1, 2)), "N s/m, N m s")


@lru_cache(maxsize=16)
def _learned(model: Model) -> casadi.Function:
    q, qd = casadi.SX.sym("q", model.n_q), casadi.SX.sym("qd", model.n_q)
    parameters = casadi.SX.sym("parameters", model.n_parameters)
    matrix = casadi.jacobian(model.friction(q, qd, parameters), qd)
    return casadi.Function("damping", [q, qd, parameters], [casadi.densify(matrix)], {"cse": True})


@lru_cache(maxsize=16)
def _true(system: System) -> casadi.Function:
    q, qd = casadi.SX.sym("q", system.n_q), casadi.SX.sym("qd", system.n_q)
    rayleigh = casadi.SX(system.dissipation(casadi.vertsplit(q), casadi.vertsplit(qd), casadi))
    return casadi.Function("damping", [q, qd], [casadi.densify(casadi.hessian(rayleigh, qd)[0])])


def _has_friction(model: Model) -> bool:
    q, qd = casadi.SX.sym("q", model.n_q), casadi.SX.sym("qd", model.n_q)
    friction = model.friction(q, qd, casadi.SX.sym("parameters", model.n_parameters))
    return friction.nnz() > 0 and not friction.is_zero()
