"""What every optimiser offers."""

from abc import ABC, abstractmethod
from typing import ClassVar

from torch import Tensor

from repro.learning.result import Checkpoint, Fitted, Progress
from repro.learning.training_problem import TrainingProblem


class Optimiser(ABC):
    """A way to fit all members of a problem; its settings are the fields of a frozen dataclass."""

    linear_only: ClassVar[bool] = False  # needs a model that is linear in its parameters, and the inverse equation

    @abstractmethod
    def fit(self, problem: TrainingProblem, parameters: Tensor, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Start from `parameters` (member, n_parameters) and return the fitted ones."""

    def lasting(self, epochs: int) -> "Optimiser":
        """The optimiser for so many epochs, where it counts in epochs."""
        return self

    def shortened(self, share: float) -> "Optimiser":
        """The optimiser for a share of its epochs or iterations, where it counts them."""
        return self

    def continued(self) -> "Optimiser":
        """The optimiser for a later phase, which starts from weights that are already good."""
        return self
