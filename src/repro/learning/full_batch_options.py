"""Options of the optimisers that look at all samples at once."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self

from repro.learning.optimiser_options import OptimiserOptions
from repro.plugins.options import Count, Natural


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
