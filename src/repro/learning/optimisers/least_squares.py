"""Closed-form least squares for models that are linear in their parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Literal, Self

from repro.learning.optimiser_options import OptimiserOptions
from repro.plugins.options import NotNegative

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


@dataclass(frozen=True)
class Options(OptimiserOptions):
    """Options of optimiser=least_squares.

    cutoff: singular values below this share of the largest count as zero. regularise_towards: where the directions stay
    that the data do not determine.
    """

    linear_only: ClassVar[bool] = True

    cutoff: NotNegative = 1e-8
    regularise_towards: Literal["zero", "start"] = "zero"

    def continued(self) -> Self:
        """What the data of a later phase do not determine stays as the phases before have left it."""
        return replace(self, regularise_towards="start")


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.least_squares import LeastSquares

    return LeastSquares(**vars(options))
