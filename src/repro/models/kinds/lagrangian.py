"""L = T - V with T linear in a basis or a network of it, and V linear in cosines."""

from dataclasses import dataclass
from typing import ClassVar

from repro.models.context import Context
from repro.models.damped import with_damping
from repro.models.lagrangian import Lagrangian, Start
from repro.models.model import Model
from repro.models.model_options import Activation, Damping, ModelOptions
from repro.plugins.options import Count

WIDE = 16.0  # spreads of the data within a unit's quadratic range


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=lagrangian: what each is stands in conf/model/lagrangian.yaml."""

    joinable: ClassVar[bool] = True
    runs_on_device: ClassVar[bool] = True
    has_coefficients: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (10,)
    activation: Activation = "softplus"
    initialisation: Start = "glorot"
    momentum_hidden: tuple[Count, ...] | None = None
    damping: Damping = "none"

    @property
    def draws_coefficients(self) -> bool:
        """Its start is one of the coefficients of a linear basis."""
        return self.initialisation in ("positive", "ones")

    @property
    def reads_spread(self) -> bool:
        """Where networks of positions are beside the basis, or its own network starts by the size of its inputs."""
        return self.initialisation == "wide" or self.momentum_hidden is not None or self.damping != "none"


def build(context: Context, options: Options) -> Model:
    """The model, beside friction where chosen."""
    model = Lagrangian(
        context.basis,
        context.n_q,
        hidden=options.hidden,
        activation=options.activation,
        input_scale=WIDE * context.feature_scale if options.initialisation == "wide" else None,
        momentum_hidden=options.momentum_hidden,
        positions=context.positions,
        initialisation=options.initialisation,
    )
    return with_damping(model, options.damping, context.positions)
