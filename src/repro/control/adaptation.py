"""Re-identification on line: a Kalman filter of a model's weights on its momentum balance, from the fit as prior."""

from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.control.momentum_balance import MomentumBalance, forces, friction_slopes, information, momenta
from repro.models.model import Model

POSITIONS = 64  # where the mass matrix must stay positive definite
LEAST = 0.1  # of its least eigenvalue before
HALVINGS = 6
ROUNDING = 1e-9  # N s


@dataclass(frozen=True)
class Prior:
    """What the fit knew: weights (n_w,), their covariance (n_w, n_w), and the momentum's size in its data, (n_q,).

    The inverse covariance is the information of the training data for a model whose forces may be wrong by a share
    `error` of their size there, mean(J'J) / (error * rms(tau))^2: it says which combinations of weights the data have
    pinned. The others are expected to stay within the size of the weights. Friction, of which data say little where
    inertia and gravity rule, may be wrong by a force that takes `friction` of the momentum a second, 1/s.
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
        rubbed = friction_slopes(model, q, qd, weights) / (friction * momentum)[:, None]
        rubbed = rubbed.reshape(-1, len(weights))
        known = information(model, q, qd, qdd, weights) / (error * size) ** 2 + rubbed.T @ rubbed / len(q)
        spread = np.mean(weights**2)
        return cls(weights, np.linalg.inv(known + np.eye(len(weights)) / spread), momentum)


@dataclass
class Identification:
    """Weights that follow what is measured; for a model linear in them this is the optimal linear estimate.

    Since the start the inputs have given as much momentum as the measured motion shows, but for what was measured
    wrongly at its two ends, and for a drift of what no weights explain. So the filter knows the weights w and the
    unexplained momentum b,

        sum of impulses = C w + b + noise now,    b <- b + drift at every stretch,

    C the sum of the balance's slopes. Noise of measurements enters at the ends alone: long motions average it out.
    A step that the stretch answers otherwise than foreseen, or that leaves the mass matrix without a good part of its
    least eigenvalue, is halved, and at last not made.
    noise, drift: standard deviations of a measured momentum and of what a stretch leaves unexplained, as shares of the
    momentum's size.
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
        """Learn from one stretch, which begins where the last one ended; what is not finite teaches nothing.

        samples: (intervals + 1, 2 n_q); applied: (intervals,) on the inputs, held between samples.
        """
        error, slope = self.balance.error(samples, applied, self.weights)
        if not (np.all(np.isfinite(error)) and np.all(np.isfinite(slope))):
            self._begin(self.covariance[: len(self.weights), : len(self.weights)])
            return
        self._impulses += error + slope @ self.weights
        self._slope += slope
        n_w, n_q = len(self.weights), len(self.unexplained)
        self.covariance[n_w:, n_w:] += self._drift
        seen = np.hstack([self._slope, np.eye(n_q)]) @ self.covariance
        expected = seen[:, :n_w] @ self._slope.T + seen[:, n_w:] + self._noise
        gain = np.linalg.solve(expected, seen).T
        self.covariance -= gain @ seen
        self.covariance = (self.covariance + self.covariance.T) / 2
        step = gain @ (self._impulses - self._slope @ self.weights - self.unexplained)
        for _ in range(HALVINGS):
            weights = self.weights + step[:n_w]
            after, _ = self.balance.error(samples, applied, weights)
            foreseen = slope @ step[:n_w]
            surprise = np.linalg.norm(error - after - foreseen)
            if surprise <= np.linalg.norm(foreseen) / 2 + ROUNDING and self._least_eigenvalue(weights) >= self._least:
                self.weights, self.unexplained = weights, self.unexplained + step[n_w:]
                return
            step = step / 2
        self.refused += 1

    def _begin(self, covariance: np.ndarray) -> None:
        """From where we are, with what is known of the weights."""
        n_w, n_q = len(self.weights), self.balance.model.n_q
        self.unexplained, self._impulses, self._slope = np.zeros(n_q), np.zeros(n_q), np.zeros((n_q, n_w))
        self.covariance = np.block([[covariance, self._slope.T], [self._slope, self._noise]])

    def _least_eigenvalue(self, weights: np.ndarray) -> float:
        matrices = evaluate(self._mass, self._positions, weights)
        return float(np.linalg.eigvalsh(matrices).min())
