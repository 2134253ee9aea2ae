"""L-BFGS: quasi-Newton, full batch."""

from __future__ import annotations

from typing import TYPE_CHECKING

from repro.learning.optimiser_options import LBFGSOptions

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


class Options(LBFGSOptions):
    """Options of optimiser=lbfgs."""


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.lbfgs import LBFGS

    return LBFGS(**vars(options))
