"""The trivial anchor row: tau = 0, qdd = 0, no energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.models.model_options import ModelOptions

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """model=trivial has no options."""

    fitted: ClassVar[bool] = False
    controllable: ClassVar[bool] = False


def build(context: Context, options: Options) -> Model:
    """The model that predicts zeros."""
    from repro.models.anchors import Trivial

    return Trivial(context.n_q)
