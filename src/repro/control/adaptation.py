"""Re-identification on line: recursive least squares on the momentum balance, from the fit as prior."""

from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from repro.control.momentum_balance import MomentumBalance, forces, information
from repro.mechanics.derive import evaluate
from repro.models.model import Model

POSITIONS = 64  # where the mass matrix must stay positive definite
LEAST = 0.1  # of its least eigenvalue before
HALVINGS = 6


@dataclass(frozen=True)
class Prior:
    """What the fit knew: weights (n_w,) and information (n_w, n_w), the inverse of their covariance.

    The information is that of the training data for a model whose forces may be wrong by a share `error` of their size
    there, Lambda = mean(J'J) / (error * rms(tau))^2: it says which combinations of weights the data have pinned. The
    others are expected to stay within the size of the weights.
    """

    weights: np.ndarray
    information: np.ndarray

    @classmethod
    def of(
        cls,
        model: Model,
        weights: np.ndarray,
        q: np.ndarray,
        qd: np.ndarray,
        qdd: np.ndarray,
        error: float,
    ) -> "Prior":
        """The prior of a model fitted to samples (sample, n_q), of an expected relative error."""
        raw = information(model, q, qd, qdd, weights)
        size = np.sqrt(np.mean(np.sum(forces(model, q, qd, qdd, weights) ** 2, axis=-1)))
        spread = np.sqrt(np.mean(weights**2))
        return cls(weights, raw / (error * size) ** 2 + np.eye(len(raw)) / spread**2)


@dataclass
class Identification:
    """Weights that follow what is measured; for a model linear in them this is exact recursive least squares.

    Each stretch adds J'J / deviation^2 to the information and moves the weights by the Gauss-Newton step. A step that
    explains the stretch worse than before, or leaves the mass matrix without a good part of its least eigenvalue, is
    halved, and at last not made.
    deviation: standard deviation of the balance's error, N s: the trust in one stretch.
    """

    balance: MomentumBalance
    prior: Prior
    deviation: float
    weights: np.ndarray = field(init=False)
    information: np.ndarray = field(init=False)
    refused: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self.weights, self.information = self.prior.weights.copy(), self.prior.information.copy()
        model = self.balance.model
        self._positions = np.random.default_rng(0).uniform(-np.pi, np.pi, (POSITIONS, model.n_q))
        q, w = ca.SX.sym("q", model.n_q), ca.SX.sym("w", model.n_parameters)
        qd = ca.SX.sym("qd", model.n_q)
        mass = ca.substitute(ca.jacobian(model.momentum(q, qd, w), qd), qd, ca.SX.zeros(model.n_q))
        self._mass = ca.Function("mass", [q, w], [ca.densify(mass)], {"cse": True})
        self._least = LEAST * self._least_eigenvalue(self.prior.weights)

    def update(self, samples: np.ndarray, applied: np.ndarray) -> None:
        """Learn from one stretch; what is not finite teaches nothing."""
        error, slope = self.balance.error(samples, applied, self.weights)
        if not (np.all(np.isfinite(error)) and np.all(np.isfinite(slope))):
            return
        self.information += slope.T @ slope / self.deviation**2
        step = np.linalg.solve(self.information, slope.T @ error / self.deviation**2)
        for _ in range(HALVINGS):
            weights = self.weights + step
            after, _ = self.balance.error(samples, applied, weights)
            if np.linalg.norm(after) <= np.linalg.norm(error) and self._least_eigenvalue(weights) >= self._least:
                self.weights = weights
                return
            step = step / 2
        self.refused += 1

    def _least_eigenvalue(self, weights: np.ndarray) -> float:
        matrices = evaluate(self._mass, self._positions, weights)
        return float(np.linalg.eigvalsh(matrices).min())
