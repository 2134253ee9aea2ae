"""T = qd' M(q) qd / 2 with M = C C', and V a network of all positions: for bodies whose forces are not only weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.models.options import Activation, Damping, ModelOptions
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
    """The model, beside friction where chosen.

    The true system declares which coordinates are angles; without one, all but the first are.
    """
    import numpy as np

    from repro.models.damped import with_damping
    from repro.models.neural_potential import NeuralPotential

    if context.system is None:
        angles = list(range(1, context.n_q))
    else:
        angles = [i for i, coordinate in enumerate(context.system.coordinates) if coordinate.is_angle]
    spread = context.q.reshape(-1, context.n_q).std(axis=0)
    model = NeuralPotential(
        context.velocity_scale,
        np.where(spread > 0, spread, 1.0),
        angles,
        hidden=options.hidden,
        potential_hidden=options.potential_hidden,
        activation=options.activation,
    )
    return with_damping(model, options.damping)
