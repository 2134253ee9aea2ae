"""Online re-identification by one extended Kalman filter of state and weights: the path fit, sample by sample."""

from dataclasses import dataclass, field

import numpy as np

from repro.control.adaptation import HALVINGS, Identification
from repro.mechanics.inputs import generalised_force
from repro.models.step_model import StepModel, substeps_for


@dataclass
class FilteredIdentification(Identification):
    """Weights estimated beside the state, from what sensors with errors of size `sensors` (2 n_q,) show of it.

    Where the momentum balance takes measured states as they are, the filter weighs them against the motion that the
    model predicts. `drift`: of the momentum in one update, which no weights explain; `noise` has no part in it.
    """

    sensors: np.ndarray = field(kw_only=True)
    _state: np.ndarray | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._steps = StepModel(self.balance.model)

    def update(self, samples: np.ndarray, applied: np.ndarray) -> None:
        """Learn from one motion, as `Identification.update` does."""
        if not np.isfinite(samples).all():
            self._begin(self.covariance[-len(self.weights) :, -len(self.weights) :])
            return
        state = samples[0] if self._state is None else self._state
        size = len(self.weights)
        self.covariance[-size:, -size:] += self.renewal * self.prior.covariance
        forces = generalised_force(self.balance.system, samples[:-1, : self.balance.model.n_q], applied)
        for force, seen in zip(forces, samples[1:], strict=True):
            state = self._correct(self._predict(state, force, len(applied)), seen)
        self._state = state

    def _begin(self, covariance: np.ndarray) -> None:
        """Start at the next measured state, with a covariance of the weights."""
        known = np.diag(self.sensors**2)
        between = np.zeros((len(known), len(self.weights)))
        self.covariance = np.block([[known, between], [between.T, covariance]])
        self._state = None

    def _predict(self, state: np.ndarray, force: np.ndarray, intervals: int) -> np.ndarray:
        n, n_q, dt = len(state), self.balance.model.n_q, self.balance.dt
        substeps = substeps_for(state[None, n_q:], dt)
        step = self._steps(state[None], force[None], np.array([dt]), self.weights, substeps)
        along = np.hstack([step.by_state[0], step.columns[0][:, 1:]])
        across = along @ self.covariance
        push = np.linalg.solve(np.asarray(self._mass(state[:n_q], self.weights)), np.sqrt(self._drift / intervals))
        self.covariance[:n, n:] = across[:, n:]
        self.covariance[n:, :n] = across[:, n:].T
        self.covariance[:n, :n] = across @ along.T
        self.covariance[n_q:n, n_q:n] += push @ push.T
        return np.asarray(step.states[0])

    def _correct(self, state: np.ndarray, seen: np.ndarray) -> np.ndarray:
        n = len(seen)
        cross = self.covariance[:n]
        gain = np.linalg.solve(cross[:, :n] + np.diag(self.sensors**2), cross).T
        change = gain @ (seen - state)
        for halving in range(HALVINGS):
            weights = self.weights + change[n:] / 2**halving
            if self._least_eigenvalue(weights) >= self._least:
                self.weights = weights
                break
        else:
            self.refused += 1
        self.covariance -= gain @ cross
        self.covariance = (self.covariance + self.covariance.T) / 2
        return np.asarray(state + change[:n])
