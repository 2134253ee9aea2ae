"""Port-Hamiltonian models, eq. (5) with (10) and (11): passive for any weights, by construction (Theorem 1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.models.model_options import Activation, Dissipation, ModelOptions, Structure
from repro.plugins.options import Count, NotNegative

if TYPE_CHECKING:
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=port_hamiltonian.

    energy `structured`: M > 0 and V of angles bounded, so H is bounded below; `basis`: L in the basis, where H may be
    indefinite. hidden, damping_hidden: units of each hidden layer of the energy and of J and R. floor: least eigenvalue
    of M in the scale of the velocities. momentum_hidden: hidden layers of M_hat(q), eq. (8); None: p = dL/dqd.
    """

    port_form: ClassVar[bool] = True
    joinable: ClassVar[bool] = True

    structure: Structure = "canonical"
    dissipation: Dissipation = "state"
    energy: Literal["structured", "basis"] = "structured"
    hidden: tuple[Count, ...] = (8,)
    rank: Count | None = None
    activation: Activation = "tanh"
    damping_hidden: tuple[Count, ...] = (4,)
    floor: NotNegative = 1e-4
    momentum_hidden: tuple[Count, ...] | None = None

    @property
    def uses_basis(self) -> bool:
        """Whether its energy is made of the features of the basis."""
        return self.energy == "basis"

    @property
    def couples_rates(self) -> bool:
        """A J that is not canonical couples rates."""
        return self.structure != "canonical"

    @property
    def has_momentum_transform(self) -> bool:
        """Whether it learns M_hat(q)."""
        return self.momentum_hidden is not None


def build(context: Context, options: Options) -> Model:
    """The model; with energies of a basis there is no floor."""
    from repro.models.lagrangian import Lagrangian
    from repro.models.port_hamiltonian import PortHamiltonian
    from repro.models.structured import Structured

    scale, hidden, activation = context.velocity_scale, options.hidden, options.activation
    positions = context.positions
    learned: Model
    if options.energy == "structured":
        learned = Structured(
            context.n_q,
            scale,
            hidden=hidden,
            rank=options.rank,
            activation=activation,
            potential_hidden=None if positions.upright_angles else hidden,
            positions=positions,
        )
    else:
        learned = Lagrangian(context.basis, context.n_q, hidden=hidden, activation=activation)
    return PortHamiltonian(
        learned,
        scale,
        structure=options.structure,
        dissipation=options.dissipation,
        hidden=options.damping_hidden,
        floor=options.floor if options.energy == "structured" else 0.0,
        momentum_hidden=options.momentum_hidden,
        positions=positions,
    )
