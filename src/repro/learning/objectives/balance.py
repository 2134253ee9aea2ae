"""The balance of momentum over windows, which needs no accelerations: see `repro.learning.balance`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.learning.objectives import inverse
from repro.plugins.options import Positive

if TYPE_CHECKING:
    from repro.data.dataset import Dataset
    from repro.learning.objective import Objective
    from repro.learning.training_problem import TrainingTask
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(inverse.Options):
    """Options of objective=balance; window: s over which momentum is balanced."""

    needs_accelerations: ClassVar[bool] = False

    window: Positive = 0.2

    def task(self, model: Model, dataset: Dataset, minimised: Objective) -> TrainingTask:
        """The rows of the inverse equation, integrated over each window."""
        from repro.learning.balance import balance_task

        return balance_task(model, dataset, minimised, self.window, self.error_scale)
