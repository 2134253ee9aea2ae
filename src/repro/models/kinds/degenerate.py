"""The degenerate anchor row: L = p^2 / (2 m) of one cyclic coordinate, no gravity, a mass matrix of rank one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.errors import UserError
from repro.models.model_options import ModelOptions

if TYPE_CHECKING:
    from repro.mechanics.system import System
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """model=degenerate has no options."""

    fitted: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    from_true_system: ClassVar[bool] = True

    def system_problem(self, system: System) -> str | None:
        """It needs a cyclic coordinate that an input drives."""
        from repro.models.anchors import Degenerate

        try:
            Degenerate(system)
        except UserError as error:
            return str(error)
        return None


def build(context: Context, options: Options) -> Model:
    """The model; UserError without the true system."""
    from repro.models.anchors import Degenerate

    return Degenerate(context.true_system)
