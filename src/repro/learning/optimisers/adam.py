"""Adam as the paper's Keras runs it, plain or with a cosine schedule; and stochastic gradient descent."""

from __future__ import annotations

from typing import TYPE_CHECKING

from repro.learning.optimiser_options import AdamOptions

if TYPE_CHECKING:
    from repro.learning.optimiser import Optimiser


class Options(AdamOptions):
    """Options of optimiser=adam, adam_cosine and sgd."""


def build(options: Options) -> Optimiser:
    """The optimiser."""
    from repro.learning.adam import Adam

    return Adam(**vars(options))
