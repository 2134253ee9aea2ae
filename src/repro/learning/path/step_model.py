"""StepDerivatives of a model under a held force, and their derivatives by state, weights and force.

Classical Runge-Kutta, differentiated stage by stage. With tau_hat(q, v, a, w) the inverse model, a stage's acceleration
has da = M^-1 (dtau - tau_q dq - tau_v dv - tau_w dw): no derivative of M^-1 is ever formed.
"""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import casadi
import numpy as np

from repro.codegen.c_library import CompilerError, load_library
from repro.codegen.c_source import c_source
from repro.codegen.compiled_evaluation import LONG, evaluation, vector_function
from repro.codegen.lanes import FAST, FUNCTIONS, TYPE
from repro.models.model import Model

TOGETHER = 512  # steps that are differentiated at once, without a compiler


@dataclass(frozen=True)
class StepDerivatives:
    """Linearised steps: next states (step, 2 n_q), and derivatives by state, weights and force (step, 2 n_q, ...)."""

    states: np.ndarray
    by_state: np.ndarray
    by_weights: np.ndarray
    by_force: np.ndarray


class StepModel:
    """The steps of a model; `compiled=False` is the slower way, with the same result."""

    def __init__(self, model: Model, compiled: bool = True) -> None:
        self.n_q, self.n_weights = model.n_q, model.n_parameters
        self.inertia, self.jacobians = _functions(model)
        self._run = _library(model) if compiled else None

    def __call__(
        self, states: np.ndarray, tau: np.ndarray, step: np.ndarray, weights: np.ndarray, substeps: int
    ) -> StepDerivatives:
        """states (step, 2 n_q), tau (step, n_q) held over step (step,) s, each divided into `substeps`."""
        points = np.concatenate([states, tau, step[:, None]], axis=1)
        with np.errstate(all="ignore"):
            result = self._interpreted(points, weights, substeps) if self._run is None else self._run(
                points, weights, substeps
            )  # fmt: skip
        edges = np.cumsum([1, 2 * self.n_q, self.n_weights])
        following, *parts = np.split(result, edges, axis=2)
        return StepDerivatives(following[..., 0], *parts)

    def _interpreted(self, points: np.ndarray, weights: np.ndarray, substeps: int) -> np.ndarray:
        parts = [points[start : start + TOGETHER] for start in range(0, len(points), TOGETHER)]
        return np.concatenate([self._some(part, weights, substeps) for part in parts])

    def _some(self, points: np.ndarray, weights: np.ndarray, substeps: int) -> np.ndarray:
        n_x = 2 * self.n_q
        tau, h = points[:, n_x:-1], points[:, -1, None, None] / substeps
        # the state is the first column, so that one rule advances it and its derivatives
        joined = np.zeros((len(points), n_x, 1 + n_x + self.n_weights + self.n_q))
        joined[..., 0] = points[:, :n_x]
        joined[:, :, 1 : 1 + n_x] = np.eye(n_x)
        for _ in range(substeps):
            k1 = self._rate(joined, tau, weights)
            k2 = self._rate(joined + h / 2 * k1, tau, weights)
            k3 = self._rate(joined + h / 2 * k2, tau, weights)
            k4 = self._rate(joined + h * k3, tau, weights)
            joined = joined + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return joined

    def _rate(self, joined: np.ndarray, tau: np.ndarray, weights: np.ndarray) -> np.ndarray:
        n, n_x = self.n_q, 2 * self.n_q
        state, columns = joined[..., 0], joined[..., 1:]
        own = evaluation(self.inertia)(state, weights)
        inverse = _inverse(own[:, : n * n].reshape(-1, n, n))
        acceleration = (inverse @ (tau - own[:, n * n :])[..., None])[..., 0]
        at = np.concatenate([state, acceleration], axis=1)
        jacobian = inverse @ evaluation(self.jacobians)(at, weights).reshape(len(at), n, -1)
        rate = np.empty_like(joined)
        rate[:, :n] = joined[:, n:]
        rate[:, n:, 0] = acceleration
        rate[:, n:, 1:] = -jacobian[..., :n_x] @ columns
        rate[:, n:, 1 + n_x : 1 + n_x + self.n_weights] -= jacobian[..., n_x:]
        rate[:, n:, 1 + n_x + self.n_weights :] += inverse
        return rate


def _inverse(matrices: np.ndarray) -> np.ndarray:
    """NaN where a matrix is singular."""
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        return np.full_like(matrices, np.nan)


@lru_cache(maxsize=16)
def _functions(model: Model) -> tuple[casadi.Function, casadi.Function]:
    """[M row by row; tau_hat at qdd = 0] of [q; qd], and [tau_q, tau_v, tau_w] row by row of [q; qd; qdd]."""
    n = model.n_q
    x, weights = casadi.SX.sym("x", 3 * n), casadi.SX.sym("parameters", model.n_parameters)
    q, qd, qdd = casadi.vertsplit(x, n)
    rest = model.inverse_dynamics(q, qd, casadi.SX.zeros(n), weights)
    mass = casadi.jacobian(model.momentum(q, qd, weights), qd)
    tau = model.inverse_dynamics(q, qd, qdd, weights)
    jacobian = casadi.horzcat(casadi.jacobian(tau, casadi.vertcat(q, qd)), casadi.jacobian(tau, weights))

    def function(name: str, at: casadi.SX, *parts: casadi.SX) -> casadi.Function:
        return casadi.Function(name, [at, weights], [casadi.densify(casadi.vertcat(*parts))], {"cse": True})

    inertia = function("inertia", casadi.vertcat(q, qd), casadi.vec(mass.T), rest)
    return inertia, function("jacobians", x, casadi.vec(jacobian.T))


@lru_cache(maxsize=16)
def _library(model: Model) -> Callable[[np.ndarray, np.ndarray, int], np.ndarray] | None:
    """The compiled steps, or None where there is no compiler."""
    inertia, jacobians = _functions(model)
    n, n_weights = model.n_q, model.n_parameters
    parts = [vector_function(inertia, "inertia"), vector_function(jacobians, "jacobians")]
    text = TYPE + FUNCTIONS + "".join(parts) + c_source(__file__, "linearised_steps", n_q=n, n_weights=n_weights)
    flags = ("-O1", *FAST[1:]) if jacobians.n_instructions() > LONG else FAST
    try:
        run = load_library(text, flags).linearised
    except (CompilerError, OSError):
        return None
    run.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p]
    run.restype = None

    def linearised(points: np.ndarray, weights: np.ndarray, substeps: int) -> np.ndarray:
        given, at = (np.ascontiguousarray(each, dtype=float) for each in (points, weights))
        result = np.empty((len(given), 2 * n, 1 + 3 * n + n_weights))
        run(given.ctypes.data, len(given), substeps, at.ctypes.data, result.ctypes.data)
        return result

    return linearised
