"""Online re-identification: a Kalman filter of a model's weights on its momentum balance, with the fit as prior.

    p(t_n) - p(t_0) = integral of (tau + dL/dq - friction),   p = dL/dqd,

holds along every motion of a model. It needs positions, velocities and the inputs, no accelerations; for a model
that is linear in its weights it is linear in them.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.control.controller import ControlStep
from repro.control.predictive_controller import PredictiveController
from repro.mechanics.inputs import input_matrix
from repro.mechanics.system import System
from repro.models.model import Model

POSITIONS = 64  # positions at which the mass matrix must stay positive definite
LEAST = 0.1  # share of its least eigenvalue before that must remain
HALVINGS = 6  # of a step that is too long
ROUNDING = 1e-9  # N s


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
        explained, jacobian = self._explained(samples.T, weights)
        return self.impulse(samples, inputs) - np.asarray(explained).ravel(), np.asarray(jacobian)

    def impulse(self, samples: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """The impulse of the inputs along one motion, (n_q,) in N s."""
        at_samples = input_matrix(self.system, samples[:, : self.model.n_q])
        forces = ((at_samples[:-1] + at_samples[1:]) / 2 @ inputs[..., None])[..., 0]
        return np.asarray(np.sum(np.ascontiguousarray(forces.T), axis=1) * self.dt)

    def explained(self, motions: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the model explains of many motions, each (intervals + 1, 2 n_q).

        Returns impulses (motion, n_q) in N s, and d(explained)/d(weights), (motion, n_q, n_weights).
        """
        n_q = self.model.n_q
        columns = evaluate(self._columns, motions, weights, repeated=True)
        momentum, force = np.split(columns.reshape(*columns.shape[:-1], -1, n_q), 2, axis=-2)
        totals = momentum[:, -1] - momentum[:, 0] - np.einsum("k,nkwi->nwi", self._simpson, force)
        return totals[:, 0], totals[:, 1:].swapaxes(1, 2)

    @cached_property
    def is_linear(self) -> bool:
        """Whether what the model explains is linear in its weights."""
        return int(self._explained.jac_sparsity(1, 1).nnz()) == 0

    @property
    def _simpson(self) -> np.ndarray:
        return np.asarray(self.dt / 3 * np.array([1, *[4, 2] * (self.intervals // 2 - 1), 4, 1]))

    @cached_property
    def _columns(self) -> ca.Function:
        """(x, weights) -> momentum, its slopes by each weight, force and its slopes, below each other."""
        x, w = ca.SX.sym("x", 2 * self.model.n_q), ca.SX.sym("w", self.model.n_parameters)
        momentum, force, of_momentum, of_force = self._parts(x, w)
        slopes = [ca.vec(ca.densify(each)) for each in (of_momentum, of_force)]
        return column_function("columns", [x, w], momentum, slopes[0], force, slopes[1])

    @cached_property
    def _parts(self) -> ca.Function:
        """(x, weights) -> momentum, force, and their Jacobians by the weights."""
        n_q = self.model.n_q
        q, qd, w = ca.SX.sym("q", n_q), ca.SX.sym("qd", n_q), ca.SX.sym("w", self.model.n_parameters)
        energies = self.model.energies(q, qd, w)
        momentum = self.model.momentum(q, qd, w)
        force = ca.gradient(energies.kinetic - energies.potential, q) - self.model.friction(q, qd, w)
        return ca.Function(
            "parts",
            [ca.vertcat(q, qd), w],
            [momentum, force, ca.jacobian(momentum, w), ca.jacobian(force, w)],
            {"cse": True},
        )

    @cached_property
    def _explained(self) -> ca.Function:
        parts, n_q = self._parts, self.model.n_q
        samples, weights = ca.MX.sym("samples", 2 * n_q, self.intervals + 1), ca.MX.sym("w", self.model.n_parameters)
        at = [parts(samples[:, k], weights) for k in range(self.intervals + 1)]
        explained, jacobian = (
            at[-1][part]
            - at[0][part]
            - sum(share * each[1 + part] for share, each in zip(self._simpson, at, strict=True))
            for part in (0, 2)
        )
        return ca.Function("explained", [samples, weights], [explained, jacobian])


@dataclass(frozen=True)
class Prior:
    """The fit as a prior: weights (n_w,), their covariance (n_w, n_w), and the rms momentum of its data, (n_q,).

    The inverse covariance is the information of the training data for a model whose forces have a relative error
    `error`, mean(J'J) / (error * rms(tau))^2: it shows which combinations of weights the data determine. The others are
    expected to stay within the size of the weights. Friction, which the data determine poorly where inertia and gravity
    dominate, may be wrong by a force that changes the momentum at the rate `friction`, 1/s.
    """

    weights: np.ndarray
    covariance: np.ndarray
    momentum: np.ndarray

    @classmethod
    def of(
        cls, model: Model, weights: np.ndarray, samples: tuple[np.ndarray, ...], error: float, friction: float
    ) -> "Prior":
        """The prior of a model fitted to samples of q, qd and qdd, each (sample, n_q)."""
        n_w, count = len(weights), len(samples[0])

        def at_samples(expression: Callable[..., Any], *arrays: np.ndarray) -> np.ndarray:
            return sampled(model, expression, arrays, weights)

        size = np.sqrt(np.mean(np.sum(at_samples(model.inverse_dynamics, *samples) ** 2, axis=-1)))
        momentum = np.sqrt(np.mean(at_samples(model.momentum, *samples[:2]) ** 2, axis=0))
        of_forces = at_samples(lambda *at: ca.jacobian(model.inverse_dynamics(*at), at[-1]), *samples)
        of_friction = at_samples(lambda *at: ca.jacobian(model.friction(*at), at[-1]), *samples[:2])
        forces = of_forces.reshape(-1, n_w)
        slowed = (of_friction.reshape(count, -1, n_w) / (friction * momentum)[:, None]).reshape(-1, n_w)
        of_data = forces.T @ forces / count / (error * size) ** 2 + slowed.T @ slowed / count
        spread = np.mean(weights**2)
        return cls(weights, np.linalg.inv(of_data + np.eye(n_w) / spread), momentum)


@dataclass
class Identification:
    """Weights estimated from the measured motion; for a model linear in them, the optimal linear estimate.

    Since the start, the impulse of the inputs equals the momentum of the measured motion, except for measurement errors
    at its two ends and a drift that no weights explain. The state of the filter is the weights w and the unexplained
    momentum b,

        sum of impulses = C w + b + noise of this measurement,    b <- b + drift at every update,

    where C is the sum of the Jacobians of the balance. Measurement noise enters at the ends only, so long motions
    average it out. A step is halved, at most HALVINGS times and then dropped, where the balance changes differently
    from its linear prediction, or where the mass matrix would lose most of its least eigenvalue.

    noise, drift: standard deviations of a measured momentum and of the unexplained momentum of one update, as shares of
    the rms momentum. renewal: share of the covariance of the prior that every update adds to that of the weights, so
    that a model that is wrong where a motion ended, at rest beside the goal, is corrected there. refused: number of
    dropped steps.
    """

    balance: MomentumBalance
    prior: Prior
    noise: float
    drift: float
    renewal: float = 0.0
    weights: np.ndarray = field(init=False)
    unexplained: np.ndarray = field(init=False)
    covariance: np.ndarray = field(init=False)
    refused: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        model, prior = self.balance.model, self.prior
        n_w, n_q = model.n_parameters, model.n_q
        self.weights = prior.weights.copy()
        self._noise, self._drift = (np.diag((share * prior.momentum) ** 2) for share in (self.noise, self.drift))
        self._begin(prior.covariance)
        self._positions = np.random.default_rng(0).uniform(-np.pi, np.pi, (POSITIONS, n_q))
        q, qd, w = (ca.SX.sym(name, size) for name, size in (("q", n_q), ("qd", n_q), ("w", n_w)))
        mass = ca.substitute(model.mass_matrix(q, qd, w), qd, ca.SX.zeros(n_q))
        self._mass = ca.Function("mass", [q, w], [ca.densify(mass)], {"cse": True})
        self._least = LEAST * self._least_eigenvalue(prior.weights)

    def update(self, samples: np.ndarray, applied: np.ndarray) -> None:
        """Learn from one motion, which begins where the last one ended; values that are not finite start a new sum.

        samples: (intervals + 1, 2 n_q); applied: (intervals, n_u), held between samples.
        """
        error, jacobian = self.balance.error(samples, applied, self.weights)
        if not (np.all(np.isfinite(error)) and np.all(np.isfinite(jacobian))):
            self._begin(self.covariance[: len(self.weights), : len(self.weights)])
            return
        self._impulses += error + jacobian @ self.weights
        self._jacobian += jacobian
        n_w, n_q = len(self.weights), len(self.unexplained)
        self.covariance[n_w:, n_w:] += self._drift
        if self.renewal:
            self.covariance[:n_w, :n_w] += self.renewal * self.prior.covariance
        cross = np.hstack([self._jacobian, np.eye(n_q)]) @ self.covariance
        innovation = cross[:, :n_w] @ self._jacobian.T + cross[:, n_w:] + self._noise
        gain = np.linalg.solve(innovation, cross).T
        self.covariance -= gain @ cross
        self.covariance = (self.covariance + self.covariance.T) / 2
        step = gain @ (self._impulses - self._jacobian @ self.weights - self.unexplained)
        for _ in range(HALVINGS):
            weights = self.weights + step[:n_w]
            after, _ = self.balance.error(samples, applied, weights)
            predicted = jacobian @ step[:n_w]
            misfit = np.linalg.norm(error - after - predicted)
            if misfit <= np.linalg.norm(predicted) / 2 + ROUNDING and self._least_eigenvalue(weights) >= self._least:
                self.weights, self.unexplained = weights, self.unexplained + step[n_w:]
                return
            step = step / 2
        self.refused += 1

    def _begin(self, covariance: np.ndarray) -> None:
        """Start a new sum at the present state, with a covariance of the weights."""
        n_w, n_q = len(self.weights), self.balance.model.n_q
        self.unexplained, self._impulses, self._jacobian = np.zeros(n_q), np.zeros(n_q), np.zeros((n_q, n_w))
        self.covariance = np.block([[covariance, self._jacobian.T], [self._jacobian, self._noise]])

    def _least_eigenvalue(self, weights: np.ndarray) -> float:
        n_q = self.balance.model.n_q
        matrices = evaluate(self._mass, self._positions, weights).reshape(-1, n_q, n_q)
        return float(np.linalg.eigvalsh(matrices).min())


class AdaptiveController:
    """A predictive controller whose weights are re-identified after every step; the time of that counts too."""

    def __init__(self, controller: PredictiveController, identification: Identification) -> None:
        self.controller, self.identification = controller, identification
        self._seconds = 0.0

    def decide(self, state: np.ndarray) -> ControlStep:
        """The inputs by the latest weights, at a measured state (2 n_q,)."""
        step = self.controller.decide(state)
        seconds, self._seconds = self._seconds, 0.0
        return replace(step, seconds=step.seconds + seconds)

    def observe(self, samples: np.ndarray, inputs: np.ndarray) -> None:
        """Update the weights from the step."""
        started = time.thread_time()
        self.identification.update(samples, inputs)
        self.controller.weights = self.identification.weights
        self._seconds = time.thread_time() - started


def sampled(
    model: Model, expression: Callable[..., Any], samples: tuple[np.ndarray, ...], weights: np.ndarray
) -> np.ndarray:
    """An expression in q, qd, ... and the weights at samples, each (sample, n_q): (sample, entries)."""
    symbols = [*(ca.SX.sym("at", model.n_q) for _ in samples), ca.SX.sym("w", model.n_parameters)]
    return evaluate(column_function("sampled", symbols, expression(*symbols)), *samples, weights)
