"""Basis selection (III-A.1): which of many candidate terms make up L."""

from __future__ import annotations

from typing import TYPE_CHECKING

from repro.learning.optimiser_options import SelectionOptions

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


class Options(SelectionOptions):
    """Options of optimiser=thresholded_least_squares and lasso."""


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.basis_selection import Selection

    return Selection(**vars(options))
