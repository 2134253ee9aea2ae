"""What every optimiser offers."""

from abc import ABC, abstractmethod

from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.result import Checkpoint, Fitted, Progress, Weights
from repro.learning.training_problem import TrainingProblem


class Optimiser(OptimiserOptions, ABC):
    """A way to fit all members of a problem; its options are the fields of a frozen dataclass."""

    @abstractmethod
    def fit(self, problem: TrainingProblem, parameters: Weights, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Start from `parameters` (member, n_parameters) and return the fitted ones."""
