"""Steps of a model under a held force, and their derivatives by state, weights and force.

Classical Runge-Kutta, differentiated stage by stage. With tau_hat(q, v, a, w) the inverse model, a stage's acceleration
has da = M^-1 (dtau - tau_q dq - tau_v dv - tau_w dw): no derivative of M^-1 is ever formed.
"""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.c_library import load_library
from repro.codegen.c_source import c_source
from repro.codegen.lanes import FAST, FUNCTIONS, TYPE, can_compile, vector_function
from repro.codegen.point_function import LONG
from repro.mechanics.runge_kutta import rk4_step
from repro.models.model import Model

TURN = 0.08  # rad that an angle turns within a sub-step
LONGEST = 0.01  # s of a sub-step
TOGETHER = 512  # steps that are differentiated at once, without a compiler


@dataclass(frozen=True)
class StepDerivatives:
    """Linearised steps: the next states (..., 2 n_q), and their derivatives (..., 2 n_q, column)."""

    states: np.ndarray
    by_state: np.ndarray  # 2 n_q columns
    columns: np.ndarray  # the next states themselves, then their derivatives by the weights
    by_force: np.ndarray  # n_q columns


class StepModel:
    """The steps of a model; `compiled=False` is the slower way, with the same result."""

    def __init__(self, model: Model, compiled: bool = True) -> None:
        self.n_q, self.n_weights = model.n_q, model.n_parameters
        self.inertia, self.jacobians = _functions(model)
        self._run = _library(model) if compiled else None

    def __call__(
        self, states: np.ndarray, tau: np.ndarray, step: np.ndarray, weights: np.ndarray, substeps: int
    ) -> StepDerivatives:
        """states (..., 2 n_q), tau (..., n_q) held over step (...) s, each divided into `substeps`.

        Where a step is NaN there is none, and everything is 0.
        """
        places = np.flatnonzero(np.isfinite(step))
        points = np.concatenate([states, tau, step[..., None]], axis=-1).reshape(-1, 3 * self.n_q + 1)[places]
        result = np.zeros((step.size, 2 * self.n_q, 1 + 3 * self.n_q + self.n_weights))
        if self._run is not None:
            self._run(points, places, np.ascontiguousarray(weights, dtype=float), substeps, result)
        else:
            with np.errstate(all="ignore"):
                for first in range(0, len(places), TOGETHER):
                    part = slice(first, first + TOGETHER)
                    result[places[part]] = self._some(points[part], weights, substeps)
        found, n, n_x = result.reshape(*step.shape, *result.shape[1:]), self.n_q, 2 * self.n_q
        return StepDerivatives(found[..., n_x], found[..., :n_x], found[..., n_x:-n], found[..., -n:])

    def _some(self, points: np.ndarray, weights: np.ndarray, substeps: int) -> np.ndarray:
        n_x = 2 * self.n_q
        tau, h = points[:, n_x:-1], points[:, -1, None, None] / substeps
        # one rule advances the state and its derivatives
        joined = np.zeros((len(points), n_x, 1 + n_x + self.n_weights + self.n_q))
        joined[..., :n_x] = np.eye(n_x)
        joined[..., n_x] = points[:, :n_x]
        for _ in range(substeps):
            joined = rk4_step(partial(self._rate, tau=tau, weights=weights), joined, h)
        return joined

    def _rate(self, joined: np.ndarray, tau: np.ndarray, weights: np.ndarray) -> np.ndarray:
        n, n_x = self.n_q, 2 * self.n_q
        state = joined[..., n_x]
        own = evaluate(self.inertia, state, weights, repeated=True)
        inverse = _inverse(own[:, : n * n].reshape(-1, n, n))
        acceleration = (inverse @ (tau - own[:, n * n :])[..., None])[..., 0]
        at = np.concatenate([state, acceleration], axis=1)
        jacobian = inverse @ evaluate(self.jacobians, at, weights, repeated=True).reshape(len(at), n, -1)
        rate = np.empty_like(joined)
        rate[:, :n] = joined[:, n:]
        rate[:, n:] = -jacobian[..., :n_x] @ joined
        rate[:, n:, n_x] = acceleration
        rate[:, n:, 1 + n_x : -n] -= jacobian[..., n_x:]
        rate[:, n:, -n:] += inverse
        return rate


def substeps_for(qd: np.ndarray, interval: float) -> int:
    """Sub-steps of an interval (s) that suit the fastest of velocities (sample, n_q)."""
    fastest = float(np.quantile(np.abs(qd).max(1), 0.995))
    return max(1, int(np.ceil(interval / min(LONGEST, TURN / max(fastest, 1e-9)))))


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
    mass = model.mass_matrix(q, qd, weights)
    tau = model.inverse_dynamics(q, qd, qdd, weights)
    jacobian = casadi.horzcat(casadi.jacobian(tau, casadi.vertcat(q, qd)), casadi.jacobian(tau, weights))
    inertia = column_function("inertia", [casadi.vertcat(q, qd), weights], casadi.vec(mass.T), rest)
    return inertia, column_function("jacobians", [x, weights], casadi.vec(jacobian.T))


@lru_cache(maxsize=16)
def _library(model: Model) -> Callable[[np.ndarray, np.ndarray, np.ndarray, int, np.ndarray], None] | None:
    """The compiled steps (points, places, weights, substeps, result), or None where there is no compiler."""
    if not can_compile():
        return None
    inertia, jacobians = _functions(model)
    parts = [vector_function(each, ("x", "parameters")) for each in (inertia, jacobians)]
    own = c_source(__file__, "linearised_steps", n_q=model.n_q, n_weights=model.n_parameters)
    flags = FAST if jacobians.n_instructions() < 2 * LONG else ("-O1", *FAST[1:])  # evaluated often: worth optimising
    run = load_library(TYPE + FUNCTIONS + "".join(parts) + own, flags).linearised
    run.argtypes = [*[ctypes.c_void_p] * 2, *[ctypes.c_int64] * 2, *[ctypes.c_void_p] * 2]
    run.restype = None

    def linearised(
        points: np.ndarray, places: np.ndarray, weights: np.ndarray, substeps: int, result: np.ndarray
    ) -> None:
        arrays = points.ctypes.data, places.ctypes.data
        run(*arrays, len(points), substeps, weights.ctypes.data, result.ctypes.data)

    return linearised
