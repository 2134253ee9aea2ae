"""The momentum balance of a model over a short motion: the error of the model, without accelerations.

    p(t_n) - p(t_0) = integral of (tau + dL/dq - friction),   p = dL/dqd,

holds along every motion of a model. It needs positions, velocities and the inputs; for a model that is linear in its
weights it is linear in them.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.inputs import input_matrix
from repro.mechanics.system import System
from repro.models.model import Model


@dataclass(frozen=True)
class MomentumBalance:
    """The balance of one model over `intervals` sampling intervals of dt s; the integral by Simpson's rule.

    ValueError for an odd number of intervals.
    """

    model: Model
    system: System
    intervals: int
    dt: float

    def __post_init__(self) -> None:
        if self.intervals % 2 or self.intervals < 2:
            raise ValueError(f"Simpson's rule needs an even number of intervals, got {self.intervals}")

    def error(self, samples: np.ndarray, inputs: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The impulse that the model does not explain, (n_q,) in N s, and d(explained)/d(weights), (n_q, n_weights).

        samples: (intervals + 1, 2 n_q); inputs: (intervals, n_u), held between samples.
        """
        at_samples = input_matrix(self.system, samples[:, : self.model.n_q])
        forces = ((at_samples[:-1] + at_samples[1:]) / 2 @ inputs[..., None])[..., 0]
        impulse = np.sum(np.ascontiguousarray(forces.T), axis=1) * self.dt
        explained, jacobian = self._explained(samples.T, weights)
        return impulse - np.asarray(explained).ravel(), np.asarray(jacobian)

    @cached_property
    def _explained(self) -> ca.Function:
        n_q = self.model.n_q
        q, qd, w = ca.SX.sym("q", n_q), ca.SX.sym("qd", n_q), ca.SX.sym("w", self.model.n_parameters)
        energies = self.model.energies(q, qd, w)
        momentum = self.model.momentum(q, qd, w)
        force = ca.gradient(energies.kinetic - energies.potential, q) - self.model.friction(q, qd, w)
        parts = ca.Function(
            "parts",
            [ca.vertcat(q, qd), w],
            [momentum, force, ca.jacobian(momentum, w), ca.jacobian(force, w)],
            {"cse": True},
        )
        samples, weights = ca.MX.sym("samples", 2 * n_q, self.intervals + 1), ca.MX.sym("w", w.numel())
        simpson = self.dt / 3 * np.array([1, *[4, 2] * (self.intervals // 2 - 1), 4, 1])
        at = [parts(samples[:, k], weights) for k in range(self.intervals + 1)]
        explained, jacobian = (
            at[-1][part] - at[0][part] - sum(share * each[1 + part] for share, each in zip(simpson, at, strict=True))
            for part in (0, 2)
        )
        return ca.Function("explained", [samples, weights], [explained, jacobian])


def information(model: Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Mean of J'J over samples (sample, n_q), J = d tau_hat / d weights: their information (n_w, n_w)."""
    symbols = _symbols(model, "q", "qd", "qdd")
    derivative = ca.jacobian(model.inverse_dynamics(*symbols), symbols[-1])
    jacobian = _at_samples(derivative, symbols, q, qd, qdd, weights).reshape(-1, model.n_parameters)
    return np.asarray(jacobian.T @ jacobian / len(q))


def friction_jacobian(model: Model, q: np.ndarray, qd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """d friction / d weights of samples (sample, n_q): (sample, n_q, n_w)."""
    symbols = _symbols(model, "q", "qd")
    jacobian = _at_samples(ca.jacobian(model.friction(*symbols), symbols[-1]), symbols, q, qd, weights)
    return jacobian.reshape(*q.shape, model.n_parameters)


def momenta(model: Model, q: np.ndarray, qd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """p = dL/dqd at samples (sample, n_q): (sample, n_q)."""
    symbols = _symbols(model, "q", "qd")
    return _at_samples(model.momentum(*symbols), symbols, q, qd, weights)


def forces(model: Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """tau_hat at samples (sample, n_q): (sample, n_q)."""
    symbols = _symbols(model, "q", "qd", "qdd")
    return _at_samples(model.inverse_dynamics(*symbols), symbols, q, qd, qdd, weights)


def _symbols(model: Model, *names: str) -> list[ca.SX]:
    return [*(ca.SX.sym(name, model.n_q) for name in names), ca.SX.sym("w", model.n_parameters)]


def _at_samples(expression: ca.SX, symbols: list[ca.SX], *arrays: np.ndarray) -> np.ndarray:
    return evaluate(ca.Function("at_samples", symbols, [ca.densify(expression)], {"cse": True}), *arrays)
