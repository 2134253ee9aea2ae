"""A trained sub-model inside a larger one: H_I = H_S + H_R, H_R of all coordinates (section IV, Proposition 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from repro.errors import UserError
from repro.models.model_options import Activation, ModelOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=extended.

    parts: the one sub-model. frozen: its weights are not fitted; else the fit starts there. rest: H_R as a structured
    model with `hidden` layers, a factor of `rank` columns (None: n_q + 2) and a linear path (skip), or in the basis.
    """

    parts: tuple[str, ...] = ("cart_rod",)
    frozen: bool = True
    rest: Literal["structured", "basis"] = "structured"
    hidden: tuple[Count, ...] = (8,)
    rank: Count | None = None
    activation: Activation = "tanh"
    skip: bool = True

    @property
    def sub_models(self) -> tuple[str, ...]:
        """The trained sub-model that it is made of."""
        return self.parts

    @property
    def uses_basis(self) -> bool:
        """Whether the rest is made of the features of the basis."""
        return self.rest == "basis"

    def parts_problem(self, n_q: int, part_sizes: Sequence[int]) -> str | None:
        """One sub-model of the first coordinates, as a cart with one rod is of a double pendulum."""
        if len(part_sizes) == 1 and part_sizes[0] < n_q:
            return None
        return f"model.parts = {list(self.parts)}: give one sub-model of fewer coordinates than the {n_q} of the system"

    def is_linear(self, basis_is_linear: bool) -> bool:
        """What is fitted beside a frozen part is the rest."""
        return self.frozen and self.rest == "basis" and basis_is_linear


def build(context: Context, options: Options) -> Model:
    """The joined model; UserError unless the one part is of the first coordinates, as a cart with one rod is."""
    from repro.models.interconnection import Interconnection, Joined, mean_inertia, remaining_scale
    from repro.models.lagrangian import Lagrangian
    from repro.models.structured import Structured

    if problem := options.parts_problem(context.n_q, [part.model.n_q for part in context.parts]):
        raise UserError(problem)
    (part,) = context.parts
    own, hidden, activation = part.model.n_q, options.hidden, options.activation
    rest: Model
    if options.rest == "basis":
        rest = Lagrangian(context.basis, context.n_q, hidden=hidden, activation=activation)
    else:
        scale = remaining_scale(context.velocity_scale, mean_inertia(part, context.q))
        rest = Structured(
            context.n_q,
            scale,
            hidden=hidden,
            rank=options.rank,
            activation=activation,
            skip=options.skip,
            positions=context.positions,
        )
    joined = [Joined(part.model, lambda q: q[:own]), Joined(rest, lambda q: q)]
    return Interconnection(joined, context.n_q, part.parameters, options.frozen)
