"""What every kind of optimiser declares: its options, and how they change from phase to phase."""

import math
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal, Self

from repro.plugins.options import Count, Natural, PluginOptions


@dataclass(frozen=True)
class OptimiserOptions(PluginOptions):
    """Options of an optimiser; a file of learning/optimisers extends it and has `build(options)`.

    unit            what it counts, if anything
    linear_only     it needs a model that is linear in its parameters, and the inverse equation
    selects         it drops terms of a basis
    handles_l1      it minimises the l1 terms of (7a)
    runs_on_device  it runs on a device other than the CPU
    name            of the file in conf/optimiser; changes no result
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = None
    linear_only: ClassVar[bool] = False
    selects: ClassVar[bool] = False
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

    def shortened(self, share: float) -> Self:
        """The same for a share of its epochs or iterations, rounded up, where it counts them."""
        return self

    def continued(self) -> Self:
        """The same for a later phase, which starts from weights that are already good."""
        return self


@dataclass(frozen=True)
class FullBatchOptions(OptimiserOptions):
    """At most `iterations` on the same `samples` random training samples of each member; None: on all."""

    unit: ClassVar[Literal["epochs", "iterations"] | None] = "iterations"

    iterations: Natural = 100
    samples: Count | None = None

    @property
    def length(self) -> int:
        """Iterations, at most."""
        return self.iterations

    def shortened(self, share: float) -> Self:
        """The same for a share of the iterations."""
        return replace(self, iterations=math.ceil(share * self.iterations))
