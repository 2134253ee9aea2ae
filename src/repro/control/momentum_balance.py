"""The momentum balance of a model over a short stretch of motion: what it gets wrong, without accelerations.

    p(t_n) - p(t_0) = integral of (tau + dL/dq - friction),   p = dL/dqd,

holds along every motion of a model. It needs positions, velocities and the force; for a model that is linear in its
weights it is linear in them.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.system import System
from repro.models.model import Model


@dataclass(frozen=True)
class MomentumBalance:
    """The balance of one model over stretches of `intervals` samples, dt s apart; the rates by Simpson's rule."""

    model: Model
    system: System
    intervals: int
    dt: float

    def __post_init__(self) -> None:
        if self.intervals % 2 or self.intervals < 2:
            raise ValueError(f"Simpson's rule needs an even number of intervals, got {self.intervals}")

    def error(self, samples: np.ndarray, forces: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the model leaves unexplained, (n_q,), and how its explanation grows with the weights, (n_q, n_weights).

        samples: (intervals + 1, 2 n_q); forces: (intervals,) on the inputs, held between samples.
        """
        impulse = self.system.input_map[:, 0] * np.sum(forces) * self.dt
        explained, slope = self._explained(samples.T, weights)
        return impulse - np.asarray(explained).ravel(), np.asarray(slope)

    @cached_property
    def _explained(self) -> ca.Function:
        n_q = self.model.n_q
        q, qd, w = ca.SX.sym("q", n_q), ca.SX.sym("qd", n_q), ca.SX.sym("w", self.model.n_parameters)
        said = self.model.energies(q, qd, w)
        momentum = self.model.momentum(q, qd, w)
        force = ca.gradient(said.kinetic - said.potential, q) - self.model.friction(q, qd, w)
        parts = ca.Function(
            "parts",
            [ca.vertcat(q, qd), w],
            [momentum, force, ca.jacobian(momentum, w), ca.jacobian(force, w)],
            {"cse": True},
        )
        samples, weights = ca.MX.sym("samples", 2 * n_q, self.intervals + 1), ca.MX.sym("w", w.numel())
        simpson = self.dt / 3 * np.array([1, *[4, 2] * (self.intervals // 2 - 1), 4, 1])
        found = [parts(samples[:, k], weights) for k in range(self.intervals + 1)]
        explained, slope = (
            found[-1][which] - found[0][which] - sum(s * f[1 + which] for s, f in zip(simpson, found, strict=True))
            for which in (0, 2)
        )
        return ca.Function("explained", [samples, weights], [explained, slope])


def information(model: Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Mean over samples of J'J, J = d tau_hat / d weights: what data (sample, n_q) say of the weights, (n_w, n_w)."""
    tau = _inverse(model)
    symbols = tau.sx_in()
    slope = ca.Function("slope", symbols, [ca.densify(ca.jacobian(tau(*symbols), symbols[-1]))], {"cse": True})
    slopes = evaluate(slope, q, qd, qdd, weights).reshape(-1, model.n_parameters)
    return slopes.T @ slopes / len(q)


def friction_slopes(model: Model, q: np.ndarray, qd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """d friction / d weights of samples (sample, n_q): (sample, n_q, n_w)."""
    symbols = _state(model)
    slope = ca.densify(ca.jacobian(model.friction(*symbols), symbols[-1]))
    slopes = evaluate(ca.Function("slope", symbols, [slope], {"cse": True}), q, qd, weights)
    return slopes.reshape(*q.shape, model.n_parameters)


def momenta(model: Model, q: np.ndarray, qd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """p = dL/dqd of samples, (sample, n_q)."""
    symbols = _state(model)
    return evaluate(ca.Function("p", symbols, [ca.densify(model.momentum(*symbols))], {"cse": True}), q, qd, weights)


def forces(model: Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """tau_hat of samples, (sample, n_q)."""
    return evaluate(_inverse(model), q, qd, qdd, weights)


def _inverse(model: Model) -> ca.Function:
    q, qd, qdd = (ca.SX.sym(name, model.n_q) for name in ("q", "qd", "qdd"))
    w = ca.SX.sym("w", model.n_parameters)
    return ca.Function("tau", [q, qd, qdd, w], [ca.densify(model.inverse_dynamics(q, qd, qdd, w))])


def _state(model: Model) -> list[ca.SX]:
    return [*(ca.SX.sym(name, model.n_q) for name in ("q", "qd")), ca.SX.sym("w", model.n_parameters)]
