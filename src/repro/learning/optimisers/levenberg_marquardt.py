"""Levenberg-Marquardt: damped Gauss-Newton, the best of several starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from repro.learning.optimiser_options import LevenbergMarquardtOptions

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


class Options(LevenbergMarquardtOptions):
    """Options of optimiser=levenberg_marquardt."""


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.levenberg_marquardt import LevenbergMarquardt

    return LevenbergMarquardt(**vars(options))
