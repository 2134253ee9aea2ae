"""The degenerate anchor row: L = p^2 / (2 m) of one cyclic coordinate, no gravity, a mass matrix of rank one."""

from dataclasses import dataclass, replace
from typing import ClassVar

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor
from repro.errors import UserError
from repro.mechanics.inputs import input_matrix
from repro.mechanics.system import System
from repro.models.context import Context
from repro.models.expression import Weightless
from repro.models.model import EnergyExpressions, Model, Prepared
from repro.models.model_options import ModelOptions
from repro.models.terms import Terms


@dataclass(frozen=True)
class Options(ModelOptions):
    """model=degenerate has no options."""

    fitted: ClassVar[bool] = False
    controllable: ClassVar[bool] = False
    from_true_system: ClassVar[bool] = True

    def system_problem(self, system: System) -> str | None:
        """It needs a cyclic coordinate that an input drives."""
        if driven_cyclic(system) is not None:
            return None
        return (
            "model=degenerate: is the momentum of a cyclic coordinate that an input drives, as a cart is; "
            f"system={system.name} has none"
        )


class Degenerate(Weightless):
    """L = p^2 / (2 m), the true momentum of the cart alone: nothing depends on the pendulum, yet its MAE_tau is small.

    It belongs to a cyclic coordinate that an input drives, so dp/dt = f holds exactly: that row of tau is right, and
    only small parts of the others are left. A fit that stops here looks good by MAE_tau and is useless: its mass matrix
    has rank one. UserError for a system without such a coordinate.
    """

    def __init__(self, system: System) -> None:
        index = driven_cyclic(system)
        if index is None:
            raise UserError(str(Options().system_problem(system)))
        super().__init__(system.n_q)
        self._kinetic, self._index = system.kinetic, index

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """No acceleration: the mass matrix is singular."""
        return replace(super().terms(outputs, prepared), mass=None)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T = p^2 / (2 m), V = 0."""
        kinetic = casadi.SX(self._kinetic(casadi.vertsplit(q), casadi.vertsplit(qd), casadi))
        momentum = casadi.gradient(kinetic, qd)[self._index]
        mass = casadi.jacobian(momentum, qd)[self._index]
        return EnergyExpressions(momentum**2 / (2 * mass), casadi.SX(0))


def driven_cyclic(system: System) -> int | None:
    """Position of the first cyclic coordinate that an input drives, or None."""
    driven = np.any(input_matrix(system, system.at_rest()) != 0, axis=1)
    return next((i for i, c in enumerate(system.coordinates) if c.cyclic and driven[i]), None)


def build(context: Context, options: Options) -> Model:
    """The model; UserError without the true system."""
    return Degenerate(context.true_system)
