"""What a fit returns, and how it reports its progress."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, TypedDict

import numpy as np

from repro.codegen.lazy_torch import Tensor

Weights = np.ndarray | Tensor  # (member, n_parameters)
Curve = list[tuple[int, str, np.ndarray]]  # (step, name, one value per member, or kept weights: see `WeightsKept`)


class Notes(TypedDict, total=False):
    """What a fit reports beside its weights: of `PathFit` cost_per_dof to zero_errors, of `DeviceAdam` what follows."""

    epochs: int
    rank: list[int]
    gauge_columns: list[str]
    cost_per_dof: list[float]
    noise: list[list[float]]
    zeros: list[list[float]]
    zero_errors: list[list[float]]
    device: str
    not_captured: str | None


@dataclass
class Fitted:
    """Weights (member, n_parameters), learning curves, and what became of each member.

    information: Fisher information of the weights (member, n_parameters, n_parameters), where the fit has one.
    """

    parameters: Weights
    curves: Curve = field(default_factory=list)
    status: list[str] = field(default_factory=list)  # "ok" or "diverged at step k", one per member
    notes: Notes = field(default_factory=Notes)
    information: np.ndarray | None = None


def continued_curves(before: Curve, after: Curve) -> Curve:
    """The curves of two fits in turn: the steps of the second begin at the last of the first."""
    offset = max((step for step, _, _ in before), default=0)
    return before + [(offset + step, name, values) for step, name, values in after]


class Checkpoint(Protocol):
    """Where a long fit keeps its state, so that it resumes after a kill."""

    def load(self) -> object | None:
        """The last saved state, or None."""

    def save(self, state: object) -> None:
        """Keep this state; called as often as the fit likes, written as often as is reasonable."""


class NoCheckpoint:
    """For short fits: nothing is saved."""

    def load(self) -> None:
        """Nothing."""

    def save(self, state: object) -> None:
        """Nothing."""


Progress = Callable[[float, str], None]  # fraction done, a few words


def part(progress: Progress, number: int, count: int, label: str = "") -> Progress:
    """The progress of one part of `count` that follow each other; its texts begin with the label."""
    return lambda fraction, text: progress((number + fraction) / count, label + text)


def silent(fraction: float, text: str) -> None:
    """Report nothing."""
