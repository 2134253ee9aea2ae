"""What every kind of optimiser declares: its options, and how they change from phase to phase."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from repro.plugins.options import PluginOptions

if TYPE_CHECKING:
    from repro.learning.result import Checkpoint, Fitted, Progress, Weights
    from repro.learning.training_problem import TrainingProblem

OPTIMISERS = "learning.optimisers"  # the folder of these choices


@dataclass(frozen=True)
class OptimiserOptions(PluginOptions):
    """An optimiser is its options; a file of learning/optimisers extends it as `Options`, and has `fit`."""

    unit: ClassVar[Literal["epochs", "iterations"] | None] = None  # what it counts, if anything
    linear_only: ClassVar[bool] = False  # it needs a model that is linear in its parameters, and the inverse equation
    selects: ClassVar[bool] = False  # it drops terms of a basis
    linearises: ClassVar[bool] = False  # it needs the Jacobian of the rows
    handles_l1: ClassVar[bool] = False  # it minimises the l1 terms of (7a)
    runs_on_device: ClassVar[bool] = False  # it runs on a device other than the CPU

    name: str = field(default="", kw_only=True)  # of the file in conf/optimiser; changes no result

    def fit(self, problem: TrainingProblem, parameters: Weights, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Start from `parameters` (member, n_parameters) and return the fitted ones of all members."""
        raise NotImplementedError

    @property
    def length(self) -> int:
        """Epochs or iterations, at most; 0 for a closed form."""
        counted: int = getattr(self, self.unit) if self.unit else 0
        return counted

    @property
    def evaluations(self) -> int:
        """About how often the fit of a member evaluates its problem."""
        return self.length

    def lasting(self, epochs: int) -> Self:
        """The same for so many epochs, where it counts in epochs."""
        return replace(self, epochs=epochs) if self.unit == "epochs" else self  # type: ignore[call-arg]

    @property
    def cut_by(self) -> str | None:
        """Name of the option that `shortened` cuts: the budget where there is one, else epochs or iterations."""
        return self.unit if getattr(self, "budget_s", None) is None else "budget_s"

    def shortened(self, share: float) -> Self:
        """The same for a share of what `cut_by` names: of the CPU seconds, or of epochs or iterations, rounded up."""
        if self.cut_by is None:
            return self
        whole = getattr(self, self.cut_by)
        cut: dict[str, Any] = {self.cut_by: whole * share if self.cut_by == "budget_s" else math.ceil(whole * share)}
        return replace(self, **cut)

    def continued(self) -> Self:
        """The same for a later phase, which starts from weights that are already good."""
        return self
