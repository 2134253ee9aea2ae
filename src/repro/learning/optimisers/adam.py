"""Adam as the paper's Keras runs it: plain, or with a cosine schedule."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Literal, Self

from repro.learning.optimiser_options import OptimiserOptions
from repro.plugins.options import Count, NotNegative, Positive

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


@dataclass(frozen=True)
class Options(OptimiserOptions):
    """Options of optimiser=adam and adam_cosine.

    schedule `keras`: learning rate / (1 + decay k) at step k; `cosine`: down to 1e-4 of it along half a cosine. engine
    `auto`: compiled code where a compiler and a kernel for model and precision exist, else torch. precision: Keras's
    default is float32, which only networks of features have a kernel for.
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = "epochs"
    handles_l1: ClassVar[bool] = True
    runs_on_device: ClassVar[bool] = True

    epochs: Count = 1000
    learning_rate: NotNegative = 0.01
    decay: NotNegative = 1e-6
    schedule: Literal["keras", "cosine"] = "keras"
    batch_size: Count = 2048
    epsilon: Positive = 1e-7
    curve_points: Count = 200
    engine: Literal["auto", "torch"] = "auto"
    precision: Literal["float64", "float32"] = "float64"

    @property
    def length(self) -> int:
        """Epochs."""
        return self.epochs

    def shortened(self, share: float) -> Self:
        """The same for a share of the epochs."""
        return replace(self, epochs=math.ceil(share * self.epochs))

    def lasting(self, epochs: int) -> Self:
        """The same for so many epochs."""
        return replace(self, epochs=epochs)


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.adam import Adam

    return Adam(**vars(options))
