"""Symplectic ODE-Net (Zhong et al. 2020): networks for M^-1, V and how inputs act, and D in its dissipative form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.models.model_options import Activation, ModelOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=symoden; hidden: of every network; dissipation `state`: D(q) is learned too."""

    controllable: ClassVar[bool] = False
    differentiable: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (64, 64)
    activation: Activation = "tanh"
    dissipation: Literal["none", "state"] = "none"


def build(context: Context, options: Options) -> Model:
    """The model."""
    from repro.models.symoden import SymODEN

    return SymODEN(
        context.n_q,
        context.positions,
        hidden=options.hidden,
        activation=options.activation,
        damped=options.dissipation == "state",
    )
