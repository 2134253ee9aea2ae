"""What the closed loop needs of a controller, and the record of one of its steps."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from repro.control.goal import Goal


@dataclass(frozen=True)
class ControlStep:
    """The inputs of one step (n_u,), and how they were computed.

    fallback    0 the solver's first answer; 1 a second try; 2 the last good plan; 3 inputs 0
    status      the solver's last word
    iterations  of all solutions
    seconds     CPU time of all solutions
    killed      number of solutions that were stopped because they took too much CPU time
    plan        predicted states (nodes, 2 n_q); empty where the controller makes no plan
    """

    u: np.ndarray
    fallback: int = 0
    status: str = ""
    iterations: int = 0
    seconds: float = 0.0
    killed: int = 0
    plan: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))


class Controller(Protocol):
    """Computes the inputs of the next step from measured states."""

    def decide(self, state: np.ndarray) -> ControlStep:
        """The inputs at a measured state (2 n_q,)."""

    def observe(self, samples: np.ndarray, inputs: np.ndarray) -> None:
        """Learn from the step: samples (n + 1, 2 n_q) measured under inputs (n, n_u) held between them."""


Samples = tuple[np.ndarray, np.ndarray, np.ndarray]
"""q, qd, qdd (sample, n_q) of training data."""
MakeController = Callable[[np.ndarray, Goal], Controller]
"""Makes a controller from the weights of a model (n_parameters,) and the goal."""
