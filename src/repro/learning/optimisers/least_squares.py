"""Closed-form least squares for models that are linear in their parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from repro.learning.optimiser_options import LeastSquaresOptions

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


class Options(LeastSquaresOptions):
    """Options of optimiser=least_squares."""


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.least_squares import LeastSquares

    return LeastSquares(**vars(options))
