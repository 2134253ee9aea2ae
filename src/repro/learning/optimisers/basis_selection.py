"""Basis selection (III-A.1): which of many candidate terms make up L."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.learning.optimiser_options import OptimiserOptions
from repro.plugins.options import NotNegative

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


@dataclass(frozen=True)
class Options(OptimiserOptions):
    """Options of optimiser=thresholded_least_squares and lasso.

    threshold: share of the signal that a term must carry (method `thresholded`). penalty: weight of the absolute
    coefficients, and refit: by least squares on the terms that remain (method `lasso`).
    """

    linear_only: ClassVar[bool] = True
    selects: ClassVar[bool] = True

    method: Literal["thresholded", "lasso"] = "thresholded"
    threshold: NotNegative = 0.05
    penalty: NotNegative = 1e-2
    refit: bool = True


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.basis_selection import Selection

    return Selection(**vars(options))
