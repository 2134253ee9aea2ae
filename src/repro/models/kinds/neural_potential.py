"""T = qd' M(q) qd / 2 with M = C C', and V a network of all positions: for bodies whose forces are not only weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.models.model_options import Activation, Damping, ModelOptions
from repro.plugins.options import Count

if TYPE_CHECKING:
    from repro.mechanics.system import System
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=neural_potential; hidden, potential_hidden: units of each hidden layer of C and of V.

    inertia: M depends on `angles` alone, or on all `positions` that are not cyclic.
    """

    joinable: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (8,)
    potential_hidden: tuple[Count, ...] = (8,)
    inertia: Literal["angles", "positions"] = "angles"
    activation: Activation = "tanh"
    damping: Damping = "none"

    def system_problem(self, system: System) -> str | None:
        """An inertia that depends on a translation needs model.inertia=positions."""
        from repro.mechanics.derive import dynamics_of

        seen = dynamics_of(system).mass_matrix.jac_sparsity(0, 0).get_col()
        hidden = [c.name for i, c in enumerate(system.coordinates) if i in seen and not c.is_angle]
        if hidden and self.inertia == "angles":
            return (
                f"model.inertia = 'angles': the inertia of system={system.name} depends on {', '.join(hidden)}; "
                "use model.inertia=positions"
            )
        return super().system_problem(system)


def build(context: Context, options: Options) -> Model:
    """The model, beside friction where chosen; V is a function of all positions, of cyclic ones too."""
    from repro.models.damped import with_damping
    from repro.models.neural_potential import NeuralPotential

    model = NeuralPotential(
        context.velocity_scale,
        context.position_scale,
        [i for i, coordinate in enumerate(context.coordinates) if coordinate.is_angle],
        moved=[i for i, _ in context.positions.translations] if options.inertia == "positions" else [],
        hidden=options.hidden,
        potential_hidden=options.potential_hidden,
        activation=options.activation,
    )
    return with_damping(model, options.damping, context.positions)
