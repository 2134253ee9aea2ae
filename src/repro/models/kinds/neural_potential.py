"""T = qd' M(q) qd / 2 with M = C C', and V a network of all positions: for bodies whose forces are not only weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.models.model_options import Activation, Damping, ModelOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=neural_potential; hidden, potential_hidden: units of each hidden layer of C and of V."""

    joinable: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (8,)
    potential_hidden: tuple[Count, ...] = (8,)
    activation: Activation = "tanh"
    damping: Damping = "none"


def build(context: Context, options: Options) -> Model:
    """The model, beside friction where chosen; V is a function of all positions, of cyclic ones too."""
    from repro.models.damped import with_damping
    from repro.models.neural_potential import NeuralPotential

    model = NeuralPotential(
        context.velocity_scale,
        context.position_scale,
        [i for i, coordinate in enumerate(context.coordinates) if coordinate.is_angle],
        hidden=options.hidden,
        potential_hidden=options.potential_hidden,
        activation=options.activation,
    )
    return with_damping(model, options.damping, context.positions)
