"""Adaptive energy-based MPC: the model's weights follow what is measured, the compiled problem stays."""

import time
from dataclasses import replace

import numpy as np

from repro.control.adaptation import Identification
from repro.control.decision import Decision
from repro.control.predictive_controller import PredictiveController


class AdaptiveController:
    """A predictive controller whose weights are re-identified after every step; its time is counted."""

    def __init__(self, controller: PredictiveController, identification: Identification) -> None:
        self.controller, self.identification = controller, identification
        self._seconds = 0.0

    def decide(self, state: np.ndarray) -> Decision:
        """The force, by the latest weights."""
        decision = self.controller.decide(state)
        seconds, self._seconds = self._seconds, 0.0
        return replace(decision, seconds=decision.seconds + seconds)

    def observe(self, samples: np.ndarray, forces: np.ndarray) -> None:
        """Learn from the step."""
        started = time.thread_time()
        self.identification.update(samples, forces)
        self.controller.weights = self.identification.weights
        self._seconds = time.thread_time() - started
