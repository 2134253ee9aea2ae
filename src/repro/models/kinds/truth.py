"""The true Lagrangian as a model: the row that no learned model can beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.errors import UserError
from repro.models.model_options import ModelOptions

if TYPE_CHECKING:
    from repro.mechanics.system import System
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=truth; damping `diagonal`: with the true viscous coefficient of each joint."""

    fitted: ClassVar[bool] = False
    from_true_system: ClassVar[bool] = True

    damping: Literal["none", "diagonal"] = "none"

    def system_problem(self, system: System) -> str | None:
        """The energies have to be those of a cart with links."""
        from repro.models.truth import Truth

        try:
            Truth(system)
        except UserError as error:
            return str(error)
        return None


def build(context: Context, options: Options) -> Model:
    """The model; UserError without the true system."""
    from repro.models.truth import DampedTruth, Truth

    return Truth(context.true_system) if options.damping == "none" else DampedTruth(context.true_system)
