"""What a fit leaves behind, and how it talks while it works."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from torch import Tensor

Curve = list[tuple[int, str, np.ndarray]]  # (step, name, value a member)


@dataclass
class Fitted:
    """Weights (member, n_parameters), learning curves, and what became of each member."""

    parameters: Tensor
    curves: Curve = field(default_factory=list)
    status: list[str] = field(default_factory=list)  # "ok" or "diverged at step k", a member each
    notes: dict = field(default_factory=dict)


class Checkpoint(Protocol):
    """Where a long fit keeps its state, so that it resumes after a kill."""

    def load(self) -> dict | None:
        """The last saved state, or None."""

    def save(self, state: dict) -> None:
        """Keep this state; called as often as the fit likes, written as often as is reasonable."""


class NoCheckpoint:
    """For short fits: nothing is kept."""

    def load(self) -> dict | None:
        """Nothing."""
        return None

    def save(self, state: dict) -> None:
        """Nothing."""


Progress = Callable[[float, str], None]  # fraction done, a few words


def silent(fraction: float, text: str) -> None:
    """Report nothing."""
