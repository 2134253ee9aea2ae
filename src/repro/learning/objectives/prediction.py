"""The error of states that are predicted over several samples, which needs no accelerations (neural ODE, SymODEN)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.learning.objective_options import ObjectiveOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.data.dataset import Dataset
    from repro.learning.objective import Objective
    from repro.learning.training_problem import TrainingTask
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ObjectiveOptions):
    """Options of objective=prediction.

    intervals: samples that are predicted from each state. scheme: classical Runge-Kutta (`rk4`), in `substeps` of an
    interval, or the implicit midpoint between recorded states (`midpoint`), which predicts one interval at a time.
    """

    linearised: ClassVar[bool] = False
    needs_energies: ClassVar[bool] = False
    needs_force: ClassVar[bool] = False
    needs_accelerations: ClassVar[bool] = False
    needs_differentiable: ClassVar[bool] = True

    intervals: Count = 4
    scheme: Literal["rk4", "midpoint"] = "rk4"
    substeps: Count = 1

    def task(self, model: Model, dataset: Dataset, minimised: Objective) -> TrainingTask:
        """Successive windows of so many intervals."""
        from repro.learning.prediction import prediction_task

        return prediction_task(model, dataset, minimised, self)
