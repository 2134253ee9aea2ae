"""What every kind of optimiser declares: its options, and how they change from phase to phase."""

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self

from repro.plugins.options import Count, Natural, PluginOptions, Positive

OPTIMISERS = "learning.optimisers"  # the folder of these choices


@dataclass(frozen=True)
class OptimiserOptions(PluginOptions):
    """Options of an optimiser; a file of learning/optimisers extends it and has `build(options)`.

    unit            what it counts, if anything
    linear_only     it needs a model that is linear in its parameters, and the inverse equation
    selects         it drops terms of a basis
    linearises      it needs the Jacobian of the rows
    handles_l1      it minimises the l1 terms of (7a)
    runs_on_device  it runs on a device other than the CPU
    name            of the file in conf/optimiser; changes no result
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = None
    linear_only: ClassVar[bool] = False
    selects: ClassVar[bool] = False
    linearises: ClassVar[bool] = False
    handles_l1: ClassVar[bool] = False
    runs_on_device: ClassVar[bool] = False

    name: str = field(default="", kw_only=True)

    @property
    def length(self) -> int:
        """Epochs or iterations, at most; 0 for a closed form."""
        return 0

    def lasting(self, epochs: int) -> Self:
        """The same for so many epochs, where it counts in epochs."""
        return self

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


@dataclass(frozen=True)
class FullBatchOptions(OptimiserOptions):
    """At most `iterations` on the same `samples` random training samples of each member; None: on all.

    budget_s: CPU seconds of a member, looked at after every iteration.
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = "iterations"

    iterations: Natural = 100
    samples: Count | None = None
    budget_s: Positive | None = None

    @property
    def length(self) -> int:
        """Iterations, at most."""
        return self.iterations
