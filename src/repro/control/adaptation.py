"""Online re-identification: a Kalman filter of a model's weights on its momentum balance, with the fit as prior."""

import time
from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.control.controller import ControlStep
from repro.control.momentum_balance import MomentumBalance, forces, friction_jacobian, information, momenta
from repro.control.predictive_controller import PredictiveController
from repro.models.model import Model

POSITIONS = 64  # positions at which the mass matrix must stay positive definite
LEAST = 0.1  # share of its least eigenvalue before that must remain
HALVINGS = 6  # of a step that is too long
ROUNDING = 1e-9  # N s


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
        cls,
        model: Model,
        weights: np.ndarray,
        q: np.ndarray,
        qd: np.ndarray,
        qdd: np.ndarray,
        error: float,
        friction: float,
    ) -> "Prior":
        """The prior of a model fitted to samples (sample, n_q)."""
        size = np.sqrt(np.mean(np.sum(forces(model, q, qd, qdd, weights) ** 2, axis=-1)))
        momentum = np.sqrt(np.mean(momenta(model, q, qd, weights) ** 2, axis=0))
        jacobian = friction_jacobian(model, q, qd, weights) / (friction * momentum)[:, None]
        jacobian = jacobian.reshape(-1, len(weights))
        of_data = information(model, q, qd, qdd, weights) / (error * size) ** 2 + jacobian.T @ jacobian / len(q)
        spread = np.mean(weights**2)
        return cls(weights, np.linalg.inv(of_data + np.eye(len(weights)) / spread), momentum)


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
    the rms momentum. refused: number of dropped steps.
    """

    balance: MomentumBalance
    prior: Prior
    noise: float
    drift: float
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
        mass = ca.substitute(ca.jacobian(model.momentum(q, qd, w), qd), qd, ca.SX.zeros(n_q))
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
