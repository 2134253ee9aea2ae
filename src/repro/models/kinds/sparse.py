"""A sparse equation of motion on a library of terms: SINDy, and with a denominator the form of SINDy-PI."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.models.model_options import ModelOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=sparse.

    form: qdd is a sum of terms (`explicit`) or a ratio of two sums (`implicit`). order: cosines, sines and translations
    that are multiplied, at most.
    """

    energetic: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    implicit_form: ClassVar[bool] = True

    form: Literal["explicit", "implicit"] = "implicit"
    order: Count = 2

    def is_linear(self, basis_is_linear: bool) -> bool:
        """Its own equation is, on any basis."""
        return True


def build(context: Context, options: Options) -> Model:
    """The model."""
    from repro.models.sparse import Sparse

    return Sparse(context.n_q, context.positions, order=options.order, implicit=options.form == "implicit")
