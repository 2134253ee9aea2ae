"""Adaptive energy-based MPC: the model's weights are re-identified; the compiled problem stays the same."""

import time
from dataclasses import replace

import numpy as np

from repro.control.adaptation import Identification
from repro.control.controller import ControlStep
from repro.control.predictive_controller import PredictiveController


class AdaptiveController:
    """A predictive controller whose weights are re-identified after every step; the time of that counts too."""

    def __init__(self, controller: PredictiveController, identification: Identification) -> None:
        self.controller, self.identification = controller, identification
        self._seconds = 0.0

    def decide(self, state: np.ndarray) -> ControlStep:
        """The force by the latest weights, at a measured state (2 n_q,)."""
        step = self.controller.decide(state)
        seconds, self._seconds = self._seconds, 0.0
        return replace(step, seconds=step.seconds + seconds)

    def observe(self, samples: np.ndarray, forces: np.ndarray) -> None:
        """Update the weights from the step."""
        started = time.thread_time()
        self.identification.update(samples, forces)
        self.controller.weights = self.identification.weights
        self._seconds = time.thread_time() - started
