"""Port-Hamiltonian models, eq. (5) with (10) and (11): passive for any weights, by construction (Theorem 1)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Literal

from repro.errors import UserError
from repro.models.model_options import Activation, Dissipation, ModelOptions, NonNegative, Structure
from repro.plugins.options import Count, NotNegative, Positive

if TYPE_CHECKING:
    from repro.mechanics.system import System
    from repro.models.context import Context
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=port_hamiltonian.

    energy `structured`: M > 0 and V of angles bounded, so H is bounded below; `basis`: L in the basis, where H may be
    indefinite; `hinged`: eq. (12), the sum of two sub-systems' energies, a cart with a rod (of `length`, m) and a free
    rod (of `rod_length`, m), joined by a hinge. parts: the trained sub-systems, or none: both are learned from the
    start, each with its own friction. frozen: what is trained is not fitted, only J and R of the whole. hidden,
    damping_hidden: units of each hidden layer of the energy and of J and R. non_negative: of the diagonal of L in
    R = L L'; relu lets a friction vanish, for good. floor: least eigenvalue of M in the scale of the velocities.
    momentum_hidden: hidden layers of M_hat(q), eq. (8); None: p = dL/dqd.
    """

    port_form: ClassVar[bool] = True
    joinable: ClassVar[bool] = True

    structure: Structure = "canonical"
    dissipation: Dissipation = "state"
    energy: Literal["structured", "basis", "hinged"] = "structured"
    parts: tuple[str, ...] = ()
    frozen: bool = False
    length: Positive = 0.5
    rod_length: Positive = 0.5
    hidden: tuple[Count, ...] = (8,)
    rank: Count | None = None
    activation: Activation = "tanh"
    damping_hidden: tuple[Count, ...] = (4,)
    non_negative: NonNegative = "softplus"
    floor: NotNegative = 1e-4
    momentum_hidden: tuple[Count, ...] | None = None

    @property
    def uses_basis(self) -> bool:
        """Whether its energy is made of the features of the basis."""
        return self.energy == "basis"

    @property
    def sub_models(self) -> tuple[str, ...]:
        """The trained sub-systems that it is made of."""
        return self.parts

    def problems(self) -> Iterator[str]:
        """Sub-systems have a place in one kind of energy only."""
        if self.parts and self.energy != "hinged":
            yield f"model.parts = {list(self.parts)}: sub-systems are joined with model.energy=hinged"

    def system_problem(self, system: System) -> str | None:
        """Hinged sub-systems are those of a double pendulum."""
        from repro.mechanics.chain import Chain

        if self.energy == "hinged" and not (isinstance(system, Chain) and system.n_q == 3):
            return f"model.energy = 'hinged': is a cart with two links, as system=dip, not system={system.name}"
        return super().system_problem(system)

    def parts_problem(self, n_q: int, part_sizes: Sequence[int]) -> str | None:
        """A cart with a rod and a free rod, or none of them."""
        if n_q == 3 and list(part_sizes) in ([], [2, 3]):
            return None
        return f"model.parts = {list(self.parts)}: give a cart with a rod and a free rod, of 2 and 3 coordinates, or []"

    @property
    def couples_rates(self) -> bool:
        """A J that is not canonical couples rates."""
        return self.structure != "canonical"

    @property
    def has_momentum_transform(self) -> bool:
        """Whether it learns M_hat(q)."""
        return self.momentum_hidden is not None


def build(context: Context, options: Options) -> Model:
    """The model; with energies of a basis there is no floor. UserError for sub-systems that cannot be joined."""
    from repro.models.lagrangian import Lagrangian
    from repro.models.port_hamiltonian import PortHamiltonian
    from repro.models.structured import Structured

    scale, hidden, activation = context.velocity_scale, options.hidden, options.activation
    positions = context.positions
    learned: Model
    if options.energy == "hinged":
        learned = _hinged(context, options)
    elif options.energy == "structured":
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
        non_negative=options.non_negative,
        floor=options.floor if options.energy == "structured" else 0.0,
        momentum_hidden=options.momentum_hidden,
        positions=positions,
    )


def _hinged(context: Context, options: Options) -> Model:
    """Two port-Hamiltonian sub-systems, trained before or to be learned, joined by a hinge."""
    import casadi

    from repro.models.kinds.hinged import joined

    if problem := options.parts_problem(context.n_q, [part.model.n_q for part in context.parts]):
        raise UserError(problem)
    alone = replace(options, energy="structured", structure="canonical", momentum_hidden=None)
    bodies = [part.model for part in context.parts] or [build(own, alone) for own in _bodies(context, options)]
    for body in bodies:
        q, qd = (casadi.SX.sym(name, body.n_q) for name in ("q", "qd"))
        friction = body.friction(q, qd, casadi.SX.sym("weights", body.n_parameters))
        if casadi.depends_on(casadi.jacobian(friction, qd), qd):
            raise UserError(
                f"model.parts = {list(options.parts)}: friction that is not linear in rates has no R, eq. (5)"
            )
    return joined(context, bodies, options.length, options.rod_length, options.frozen)


def _bodies(context: Context, options: Options) -> Iterator[Context]:
    """The motion of a double pendulum as that of its cart with a rod, and of its second rod as a free one."""
    import numpy as np

    from repro.mechanics.coordinate import Coordinate

    q, qd = context.q, context.qd
    yield replace(
        context, coordinates=context.coordinates[:2], q=q[..., :2], qd=qd[..., :2], first_qd=context.first_qd[..., :2]
    )
    arms = np.array([options.length, options.rod_length / 2])
    right, up = arms * np.sin(q[..., 1:]), arms * np.cos(q[..., 1:])
    place = np.stack([q[..., 0] + right.sum(-1), up.sum(-1), q[..., 2]], axis=-1)
    rates = np.stack([qd[..., 0] + (up * qd[..., 1:]).sum(-1), -(right * qd[..., 1:]).sum(-1), qd[..., 2]], axis=-1)
    free = (Coordinate("x", "m", False, cyclic=True), Coordinate("y", "m", False), Coordinate("theta", "rad", True))
    yield replace(context, coordinates=free, q=place, qd=rates, first_qd=rates)
