"""A double pendulum made of a learned cart with a rod and a learned free rod, joined by a hinge (section IV)."""

from __future__ import annotations

from collections.abc import Sequence
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

    def parts_problem(self, n_q: int, part_sizes: Sequence[int]) -> str | None:
        """A cart with a rod, then with rod `part` a free rod, to be joined on a double pendulum."""
        needed = [2, 3] if self.rod == "part" else [2]
        if n_q == 3 and list(part_sizes) == needed:
            return None
        names = "[cart_rod, free_rod]" if self.rod == "part" else "[cart_rod]"
        return (
            f"model.parts = {list(self.parts)}: model.rod={self.rod} on system=dip takes "
            f"{'a cart with a rod and a free rod' if self.rod == 'part' else 'a cart with a rod alone'}, as "
            f"model.parts={names}"
        )


def build(context: Context, options: Options) -> Model:
    """The joined model; UserError for parts that do not fit together."""
    from repro.models.bases import rigid_body
    from repro.models.hinged import RodOfUnknownMass
    from repro.models.lagrangian import Lagrangian

    rod = options.rod
    if problem := options.parts_problem(context.n_q, [part.model.n_q for part in context.parts]):
        raise UserError(problem)
    second: Model
    if rod == "part":
        second = context.parts[1].model
    elif rod == "mass":
        second = RodOfUnknownMass(options.rod_length, options.gravity)
    else:
        second = Lagrangian(rigid_body, 3)
    return joined(context, [context.parts[0].model, second], options.length, options.rod_length, options.frozen)


def joined(context: Context, bodies: Sequence[Model], length: float, rod_length: float, frozen: bool) -> Model:
    """A cart with a rod of `length` and a free rod of `rod_length` (m), hinged; trained parts bring their weights."""
    import numpy as np

    from repro.mechanics.chain import LinkAngles
    from repro.models.hinged import Hinged

    up = context.system.up if isinstance(context.system, LinkAngles) else 1.0
    trained = [part.parameters for part in context.parts]
    return Hinged(
        *bodies,
        length=length,
        centre=rod_length / 2,
        up=up,
        trained=np.concatenate(trained, axis=1) if trained else None,
        frozen=frozen,
    )
