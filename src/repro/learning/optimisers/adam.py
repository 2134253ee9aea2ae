"""Adam as the paper's Keras runs it: plain, or with a cosine schedule."""

from __future__ import annotations

from typing import TYPE_CHECKING

from repro.learning.optimiser_options import AdamOptions

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


class Options(AdamOptions):
    """Options of optimiser=adam and adam_cosine."""


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.adam import Adam

    return Adam(**vars(options))
