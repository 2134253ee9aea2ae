"""A structure-free baseline: qdd = N(qd, cos q, sin q, tau)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from repro.models.model_options import Activation, ModelOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=blackbox; hidden: units of each hidden layer."""

    energetic: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    runs_on_device: ClassVar[bool] = True
    differentiable: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (32, 32)
    activation: Activation = "softplus"


def build(context: Context, options: Options) -> Model:
    """The network."""
    from repro.models.blackbox import BlackBox

    return BlackBox(context.n_q, hidden=options.hidden, activation=options.activation, positions=context.positions)
