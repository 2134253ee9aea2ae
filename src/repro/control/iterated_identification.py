"""Online re-identification of a model that is not linear in its weights: a filter iterated over a fixed lag."""

from dataclasses import dataclass, field

import numpy as np

from repro.control.adaptation import HALVINGS, ROUNDING, Identification

LAG = 64  # motions that every update linearises anew


@dataclass(frozen=True)
class Belief:
    """The state of the filter after some motions: weights w (n_w,), unexplained momentum b (n_q,) and their covariance.

    impulses, jacobian: the sums of the motions since the start, C w + b = impulses but for noise; (n_q,), (n_q, n_w).
    """

    weights: np.ndarray
    unexplained: np.ndarray
    covariance: np.ndarray
    impulses: np.ndarray
    jacobian: np.ndarray

    def after(
        self, impulse: np.ndarray, jacobian: np.ndarray, noise: np.ndarray, drift: np.ndarray, doubt: np.ndarray
    ) -> "Belief":
        """The state after one motion more, jacobian w = impulse; covariances of noise, drift of b and doubt of w."""
        n_w = len(self.weights)
        impulses, total = self.impulses + impulse, self.jacobian + jacobian
        covariance = self.covariance.copy()
        covariance[:n_w, :n_w] += doubt
        covariance[n_w:, n_w:] += drift
        along = np.hstack([total, np.eye(len(impulses))])
        cross = along @ covariance
        gain = np.linalg.solve(cross @ along.T + noise, cross).T
        step = gain @ (impulses - total @ self.weights - self.unexplained)
        covariance -= gain @ cross
        covariance = (covariance + covariance.T) / 2
        return Belief(self.weights + step[:n_w], self.unexplained + step[n_w:], covariance, impulses, total)


@dataclass
class IteratedIdentification(Identification):
    """Weights of a model that is not linear in them: with every motion the last `lag` ones are filtered again.

    A Jacobian that was taken at early, wrong weights stays wrong in the sum. So every update starts from the state
    before the lag and takes all Jacobians since at the present weights: a Gauss-Newton step, one per motion, towards
    the most probable weights. A motion that leaves the lag keeps its last linearisation. A step that is halved, as
    `Identification` halves it, loses nothing: the next update starts from the same state before the lag.
    """

    lag: int = LAG
    _before: Belief = field(init=False)
    _samples: list[np.ndarray] = field(init=False)
    _driven: list[np.ndarray] = field(init=False)

    def update(self, samples: np.ndarray, applied: np.ndarray) -> None:
        """Learn from one motion, as `Identification.update` does."""
        if not np.isfinite(samples).all():
            self._begin(self.covariance[: len(self.weights), : len(self.weights)])
            return
        self._samples.append(samples)
        self._driven.append(self.balance.impulse(samples, applied))
        motions = np.stack(self._samples)
        explained, jacobians = self.balance.explained(motions, self.weights)
        targets = np.stack(self._driven) - explained + jacobians @ self.weights
        known = self._noise, self._drift, self.renewal * self.prior.covariance
        first = self._before.after(targets[0], jacobians[0], *known)
        last = first
        for target, jacobian in zip(targets[1:], jacobians[1:], strict=True):
            last = last.after(target, jacobian, *known)
        self.covariance = last.covariance
        self._step_towards(last, motions, explained, jacobians)
        if len(self._samples) == self.lag:
            self._before = first
            del self._samples[0], self._driven[0]

    def _step_towards(self, target: Belief, motions: np.ndarray, explained: np.ndarray, jacobians: np.ndarray) -> None:
        share, step = 1.0, target.weights - self.weights
        for _ in range(HALVINGS):
            weights = self.weights + share * step
            predicted = share * (jacobians @ step)
            misfit = np.linalg.norm(self.balance.explained(motions, weights)[0] - explained - predicted)
            if misfit <= np.linalg.norm(predicted) / 2 + ROUNDING and self._least_eigenvalue(weights) >= self._least:
                self.weights = weights
                self.unexplained = self.unexplained + share * (target.unexplained - self.unexplained)
                return
            share /= 2
        self.refused += 1

    def _begin(self, covariance: np.ndarray) -> None:
        super()._begin(covariance)
        self._before = Belief(self.weights, self.unexplained, self.covariance, self._impulses, self._jacobian)
        self._samples, self._driven = [], []
