"""tau_hat of a model and its Jacobians at many points: all that a fit without accelerations needs of a model."""

from dataclasses import dataclass
from functools import lru_cache

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.models.model import Model


@dataclass(frozen=True)
class InverseModel:
    """tau_hat(q, qd, qdd, w) as CasADi functions of x = [q; qd; qdd] (3 n_q,) and the weights."""

    n_q: int
    force: casadi.Function  # tau_hat (n_q,)
    by_weights: casadi.Function  # [tau_hat, d tau_hat / d w], row by row

    def forces(self, points: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """tau_hat (point, n_q) at points (point, 3 n_q)."""
        return evaluate(self.force, points, parameters, repeated=True)

    def linear(self, points: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """[tau_hat, d tau_hat / d w] (point, n_q, 1 + n_parameters)."""
        return evaluate(self.by_weights, points, parameters, repeated=True).reshape(len(points), self.n_q, -1)


@lru_cache(maxsize=16)
def inverse_model(model: Model) -> InverseModel:
    """Those of a model; ValueError where it is not written as expressions."""
    n_q = model.n_q
    x, weights = casadi.SX.sym("x", 3 * n_q), casadi.SX.sym("parameters", model.n_parameters)
    tau = model.inverse_dynamics(x[:n_q], x[n_q : 2 * n_q], x[2 * n_q :], weights)
    both = casadi.horzcat(tau, casadi.jacobian(tau, weights))
    force = column_function("force", [x, weights], tau)
    return InverseModel(n_q, force, column_function("by_weights", [x, weights], casadi.vec(both.T)))
