"""Whether the dissipation is right: the damping matrix C = d(friction)/dqd against the true one, and Theorem 1."""

from collections.abc import Iterator
from functools import lru_cache

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.data.dataset import Dataset
from repro.evaluation.model_motion import is_compiled
from repro.evaluation.pointwise import MetricValues, finite_or_infinite
from repro.mechanics.coordinate import joint_rates
from repro.mechanics.system import System
from repro.models.model import Model
from repro.models.passivity_margin import States, margins, worst_margin

STATES = 2000  # test samples over which C is averaged, and random states at which passivity is tried


def damping_errors(model: Model, parameters: np.ndarray, part: Dataset, system: System) -> Iterator[MetricValues]:
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
    yield MetricValues("test", "damping_error", error, "1")
    joints = np.linalg.inv(joint_rates(system.n_q, system.jointed))  # columns: one joint alone turns
    ours, theirs = (np.einsum("ic,mnij,jc->mnc", joints, matrix, joints) for matrix in (learned, true))
    for joint in np.flatnonzero(system.damping):
        gap = np.abs(ours[..., joint] - theirs[..., joint]).mean(1) / theirs[..., joint].mean(1)
        yield MetricValues("test", f"damping_error[{joint}]", gap, "1")
    yield MetricValues("test", "min_eig_C", np.linalg.eigvalsh(symmetric).min((1, 2)), "N s/m, N m s")


def passivity(model: Model, parameters: np.ndarray, part: Dataset, system: System | None) -> Iterator[MetricValues]:
    """The worst margin over random states by the model's own energy and by the plant's, and how often the latter fails.

    Nothing where the model's equations are singular, or neither compiled nor evaluated by the model itself.
    """
    if not is_compiled(model) and type(model).port_values is Model.port_values:
        return
    velocities = part.qd.reshape(-1, part.n_q).std(axis=0)
    states = States.random(part.coordinates, velocities, STATES, np.random.default_rng(9))
    weights = np.asarray(parameters, dtype=float)
    if model.energetic:
        yield MetricValues("test", "passivity_margin", worst_margin(model, weights, states), "1")
    if system is not None:
        by_plant = finite_or_infinite(np.stack([margins(model, member, states, system) for member in weights]))
        yield MetricValues("test", "passivity_margin_plant", by_plant.max(1), "1")
        yield MetricValues("test", "gains_energy", (by_plant > 1e-9).mean(1), "1")


@lru_cache(maxsize=16)
def _learned(model: Model) -> casadi.Function:
    q, qd, parameters = model.symbols("q", "qd")
    matrix = casadi.jacobian(model.friction(q, qd, parameters), qd)
    return casadi.Function("damping", [q, qd, parameters], [casadi.densify(matrix)], {"cse": True})


@lru_cache(maxsize=16)
def _true(system: System) -> casadi.Function:
    q, qd = casadi.SX.sym("q", system.n_q), casadi.SX.sym("qd", system.n_q)
    rayleigh = casadi.SX(system.dissipation(casadi.vertsplit(q), casadi.vertsplit(qd), casadi))
    return casadi.Function("damping", [q, qd], [casadi.densify(casadi.hessian(rayleigh, qd)[0])])


def _has_friction(model: Model) -> bool:
    friction = model.friction(*model.symbols("q", "qd"))
    return friction.nnz() > 0 and not friction.is_zero()
