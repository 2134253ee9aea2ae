"""A Hamiltonian neural network (Greydanus et al. 2019): H(q, p) on momenta that the true system gives."""

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
    """Options of model=hamiltonian; dissipation `constant`: a diagonal D is learned too (Desai et al. 2021)."""

    energetic: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    from_true_system: ClassVar[bool] = True
    port_form: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (200, 200)
    activation: Activation = "tanh"
    dissipation: Literal["none", "constant"] = "none"


def build(context: Context, options: Options) -> Model:
    """The model; UserError without the true system."""
    from repro.models.hamiltonian import Hamiltonian, momentum_spread

    system = context.true_system
    return Hamiltonian(
        system,
        context.positions,
        momentum_spread(system, context.q, context.qd),
        hidden=options.hidden,
        activation=options.activation,
        damped=options.dissipation == "constant",
    )
