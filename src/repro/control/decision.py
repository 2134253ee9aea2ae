"""What every controller offers to the closed loop, and what it tells of each of its steps."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

NO_PLAN = np.zeros((0, 0))


@dataclass(frozen=True)
class Decision:
    """One step's force, N, and how it came about.

    fallback: 0 the solver's first answer; 1 a second try; 2 the last good plan; 3 no force at all.
    seconds: CPU time of all solutions. killed: how many of them took more of it than they may. plan: predicted states
    (nodes, 2 n_q); none from a controller that makes none.
    """

    force: float
    fallback: int = 0
    status: str = ""
    iterations: int = 0
    seconds: float = 0.0
    killed: int = 0
    plan: np.ndarray = field(default_factory=lambda: NO_PLAN)


class Controller(Protocol):
    """Decides the force of the next step from what is measured."""

    def decide(self, state: np.ndarray) -> Decision:
        """The force for a measured state (2 n_q,)."""

    def observe(self, samples: np.ndarray, forces: np.ndarray) -> None:
        """Take what was measured since: samples (n + 1, 2 n_q) under forces (n,) between them."""
