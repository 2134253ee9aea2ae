"""A double pendulum made of a learned cart with a rod and a learned free rod, joined by a hinge (section IV)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from repro.errors import UserError
from repro.models.model_options import ModelOptions, Rod
from repro.plugins.options import Positive

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=hinged.

    parts: sub-models, the cart with its rod, then (rod `part`) the free rod. frozen: their weights are not fitted; else
    the fit starts there. rod: `rigid_body` fits mass, inertia and weight, `mass` its mass alone, under `gravity`
    (m/s^2). length, rod_length: m, of the first and of the second rod, a uniform one.
    """

    parts: tuple[str, ...] = ("cart_rod", "free_rod")
    frozen: bool = True
    rod: Rod = "part"
    length: Positive = 0.5
    rod_length: Positive = 0.5
    gravity: Positive = 9.8

    @property
    def sub_models(self) -> tuple[str, ...]:
        """The trained sub-models that it is made of."""
        return self.parts

    def is_linear(self, basis_is_linear: bool) -> bool:
        """What is fitted beside frozen parts are coefficients, on any basis."""
        return self.frozen


def build(context: Context, options: Options) -> Model:
    """The joined model; UserError for parts that do not fit together."""
    import numpy as np

    from repro.models.bases import rigid_body
    from repro.models.hinged import Hinged, RodOfUnknownMass
    from repro.models.lagrangian import Lagrangian

    rod = options.rod
    count = 2 if rod == "part" else 1
    coordinates = [part.model.n_q for part in context.parts]
    if coordinates != [2, 3][:count] or context.n_q != 3:
        raise UserError(
            f"model.parts = {list(options.parts)}: rod={rod} needs {count} of them: a cart with a rod "
            "(system=sip_rod), then a free rod (system=rod), to be joined on system=dip"
        )
    second: Model
    if rod == "part":
        second = context.parts[1].model
    elif rod == "mass":
        second = RodOfUnknownMass(options.rod_length, options.gravity)
    else:
        second = Lagrangian(rigid_body, 3)
    up = 1.0 if context.system is None else context.system.up
    return Hinged(
        context.parts[0].model,
        second,
        length=options.length,
        centre=options.rod_length / 2,
        up=up,
        trained=np.concatenate([part.parameters for part in context.parts], axis=1),
        frozen=options.frozen,
    )
