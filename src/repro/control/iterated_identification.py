"""Online re-identification of a model that is not linear in its weights: a filter iterated over a fixed lag."""

from dataclasses import dataclass, field

import numpy as np

from repro.control.adaptation import HALVINGS, ROUNDING, Identification

LAG = 64  # motions that every update linearises anew


@dataclass(frozen=True)
class Belief:
    """The filter after some motions: its state x = [w, b], weights (n_w,) and unexplained momentum (n_q,).

    impulses (n_q,), slopes (n_q, n_w + n_q): sums over the motions since the start; slopes x = impulses but for noise.
    """

    state: np.ndarray
    covariance: np.ndarray
    impulses: np.ndarray
    slopes: np.ndarray

    def after(self, impulse: np.ndarray, slope: np.ndarray, noise: np.ndarray, drift: np.ndarray) -> "Belief":
        """After one motion more, slope (n_q, n_w) w = impulse; covariances of the noise and of the drift of x."""
        impulses, slopes = self.impulses + impulse, self.slopes.copy()
        slopes[:, : slope.shape[1]] += slope
        covariance = self.covariance + drift
        cross = slopes @ covariance
        root = np.linalg.inv(np.linalg.cholesky(cross @ slopes.T + noise))
        gain = root @ cross
        state = self.state + gain.T @ (root @ (impulses - slopes @ self.state))
        covariance -= gain.T @ gain
        return Belief(state, covariance, impulses, slopes)


@dataclass
class IteratedIdentification(Identification):
    """Weights of a model that is not linear in them: with every motion the last `lag` ones are filtered again.

    A Jacobian that was taken at early, wrong weights stays wrong in the sum. So every update starts from the state
    before the lag and takes all Jacobians since at the present weights: a Gauss-Newton step, one per motion, towards
    the most probable weights. A motion that leaves the lag keeps its last linearisation. A step that is halved, as
    `Identification` halves it, loses nothing: the next update starts from the same state before the lag.
    """

    lag: int = LAG
    _of_state: np.ndarray = field(init=False)
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
        first = last = self._before.after(targets[0], jacobians[0], self._noise, self._of_state)
        for target, jacobian in zip(targets[1:], jacobians[1:], strict=True):
            last = last.after(target, jacobian, self._noise, self._of_state)
        self.covariance = last.covariance
        self._step_towards(last, motions, explained, jacobians)
        if len(self._samples) == self.lag:
            self._before = first
            del self._samples[0], self._driven[0]

    def _step_towards(self, target: Belief, motions: np.ndarray, explained: np.ndarray, jacobians: np.ndarray) -> None:
        n_w = len(self.weights)
        share, step = 1.0, target.state[:n_w] - self.weights
        for _ in range(HALVINGS):
            weights = self.weights + share * step
            predicted = share * (jacobians @ step)
            misfit = np.linalg.norm(self.balance.explained(motions, weights)[0] - explained - predicted)
            if misfit <= np.linalg.norm(predicted) / 2 + ROUNDING and self._least_eigenvalue(weights) >= self._least:
                self.weights = weights
                self.unexplained = self.unexplained + share * (target.state[n_w:] - self.unexplained)
                return
            share /= 2
        self.refused += 1

    def _begin(self, covariance: np.ndarray) -> None:
        super()._begin(covariance)
        of_weights = self.renewal * self.prior.covariance
        self._of_state = np.block([[of_weights, self._jacobian.T], [self._jacobian, self._drift]])
        state = np.concatenate([self.weights, self.unexplained])
        slopes = np.hstack([self._jacobian, np.eye(len(self.unexplained))])
        self._before = Belief(state, self.covariance, self._impulses, slopes)
        self._samples, self._driven = [], []
