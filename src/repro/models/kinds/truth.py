"""The true Lagrangian as a model: the row that no learned model can beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.models.model_options import ModelOptions

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=truth; damping `diagonal`: with the true friction."""

    fitted: ClassVar[bool] = False
    from_true_system: ClassVar[bool] = True

    damping: Literal["none", "diagonal"] = "none"


def build(context: Context, options: Options) -> Model:
    """The model; UserError without the true system."""
    from repro.models.truth import true_model

    return true_model(context.true_system, options.damping != "none")
