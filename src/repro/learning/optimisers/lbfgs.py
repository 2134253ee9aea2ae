"""L-BFGS: quasi-Newton, full batch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from repro.learning.optimiser_options import FullBatchOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


@dataclass(frozen=True)
class Options(FullBatchOptions):
    """Options of optimiser=lbfgs; memory: pairs that the Hessian is made of."""

    iterations: Count = 1000
    samples: Count | None = 6000
    memory: Count = 30


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.lbfgs import LBFGS

    return LBFGS(**vars(options))
