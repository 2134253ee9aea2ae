"""Levenberg-Marquardt: damped Gauss-Newton, the best of several starts."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

from repro.learning.optimiser_options import FullBatchOptions
from repro.plugins.options import Count, NotNegative, Positive

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


@dataclass(frozen=True)
class Options(FullBatchOptions):
    """Options of optimiser=levenberg_marquardt.

    damping: at the start, divided by `damping_decrease` after a success (3 suits free-form networks, 10 models that
    contain the truth). tolerance: a step that gains less than this share of the loss counts as stalled. restarts:
    random starts, tried for `trial_iterations` each; the one with the lowest training loss goes on.
    """

    iterations: Count = 300
    samples: Count | None = 3000
    damping: NotNegative = 1.0
    damping_decrease: Positive = 3.0
    tolerance: NotNegative = 1e-10
    restarts: Count = 8
    trial_iterations: Count = 40

    def shortened(self, share: float) -> Self:
        """The same for a share of the iterations, those of the trials too."""
        trial = math.ceil(share * self.trial_iterations)
        return replace(super().shortened(share), trial_iterations=trial)

    def continued(self) -> Self:
        """A later phase starts from the weights of the one before."""
        return replace(self, restarts=1)


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.levenberg_marquardt import LevenbergMarquardt

    return LevenbergMarquardt(**vars(options))
