"""Port-Hamiltonian models, eq. (5) with (10) and (11): passive for any weights, by construction (Theorem 1)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import casadi
import numpy as np

from repro.errors import UserError
from repro.mechanics.chain import Chain
from repro.mechanics.system import System
from repro.models.context import Context
from repro.models.expression import ExpressionModel
from repro.models.features import FeatureMap
from repro.models.kinds import structured
from repro.models.kinds.hinged import alone_contexts, joined
from repro.models.lagrangian import Lagrangian, MomentumTransform
from repro.models.model import EnergyExpressions, Model, PortForm, consecutive
from repro.models.model_options import Activation, Dissipation, ModelOptions, NonNegative, Structure
from repro.models.port_matrices import Factored, Skew
from repro.models.position import PositionFeatures, cart_with_links
from repro.plugins.options import Count, NotNegative, Positive


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=port_hamiltonian: what each is stands in conf/model/port_hamiltonian.yaml."""

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

    def problems(self) -> Iterator[str]:
        """Sub-systems have a place in one kind of energy only."""
        if self.parts and self.energy != "hinged":
            yield f"model.parts = {list(self.parts)}: sub-systems are joined with model.energy=hinged"

    def system_problem(self, system: System) -> str | None:
        """Hinged sub-systems are those of a double pendulum."""
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


class PortHamiltonian(ExpressionModel):
    """xdot = (J - R) dH/dx + [0; tau] in x = [q; p], H the energy of another model and p = dL/dqd its momentum.

    structure `canonical`: J = [0 I; -I 0] and R = [0 0; 0 C]; `free`: J(x) = A - A' from a network; `full`: R(x) from
    networks too. C is 0, `constant`, or of the `state` q. `floor` adds floor/2 |qd/scale|^2 to T, so that M > 0, and H
    is bounded below wherever the model's own M >= 0 and V is bounded.

    An energy that is an interconnection of sub-systems brings their friction along, which must be linear in the rates:
    R_I is the sum of theirs, seen from the whole, and of the R learned here, as that of the joints between them.

    With `momentum_hidden` the momentum has a network of its own, p = M_hat(q) qd as in eq. (8), and so has the port
    form: H = qd' p / 2 + V. The objective of eq. (12) is then the loss of L (7a), Omega_tran, and both rows of (12b).
    parameters: [those of the energy | J | R | M_hat].
    """

    def __init__(
        self,
        energy: Model,
        velocity_scale: np.ndarray,
        options: Options,
        positions: PositionFeatures | None = None,
    ) -> None:
        positions = positions or cart_with_links(energy.n_q)
        structure, hidden, non_negative = options.structure, options.damping_hidden, options.non_negative
        if options.momentum_hidden is not None:
            self.transform = MomentumTransform(energy.n_q, options.momentum_hidden, positions)
        self.energy, self.n_q, self.structure = energy, energy.n_q, structure
        self.floor = options.floor if options.energy == "structured" else 0.0
        self.fixed, self.upstream = energy.fixed, energy.upstream
        self.velocity_scale = np.asarray(velocity_scale, dtype=float)
        self.features = FeatureMap(positions.inertia, self.n_q)
        places, force_scale = len(self.features), 1 / self.velocity_scale
        scale = np.concatenate([self.velocity_scale, force_scale])
        self.skew = None if structure == "canonical" else Skew(places + self.n_q, hidden, scale)
        if structure == "full":
            self.damping: Factored | None = Factored(places + self.n_q, hidden, scale, non_negative)
        elif options.dissipation == "none":
            self.damping = None
        else:
            layers = None if options.dissipation == "constant" else hidden
            self.damping = Factored(places, layers, force_scale, non_negative)
        self._parts = energy, self.skew, self.damping, self.transform
        slices = consecutive(*(0 if part is None else part.n_parameters for part in self._parts))
        self.energy_slice, self.skew_slice, self.damping_slice, self.transform_slice = slices
        self.n_parameters = self.transform_slice.stop

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """The start of every part."""
        return np.concatenate([part.initial(generators) for part in self._parts if part is not None], axis=1)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T with its floor, and V."""
        energies = self.energy.energies(q, qd, parameters[self.energy_slice])
        least = 0.5 * self.floor * casadi.sumsqr(qd / casadi.DM(self.velocity_scale))
        return EnergyExpressions(energies.kinetic + least, energies.potential)

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """What eq. (12b) adds to the forces of L: C qd where J is canonical."""
        form = self.port_form(q, qd, parameters)
        return -form.gradient[: self.n_q] - form.drift[self.n_q :]

    def port_form(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> PortForm:
        """dH/dx and (J - R) dH/dx."""
        energies = self.energies(q, qd, parameters)
        kinetic = energies.kinetic
        if self.transform is not None:
            kinetic = 0.5 * casadi.dot(qd, self.transformed_momentum(q, qd, parameters))
        gradient = casadi.vertcat(casadi.gradient(energies.potential - kinetic, q), qd)
        return PortForm(gradient, self.structure_matrix(q, qd, parameters) @ gradient)

    def structure_matrix(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """J - R, (2 n_q, 2 n_q)."""
        return self.interconnection(q, qd, parameters) - self.resistance(q, qd, parameters)

    def interconnection(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """J, eq. (10)."""
        if self.skew is None:
            zero, identity = casadi.SX(self.n_q, self.n_q), casadi.SX.eye(self.n_q)
            return casadi.vertcat(casadi.horzcat(zero, identity), casadi.horzcat(-identity, zero))
        return self.skew.matrix(self._state(q, qd), parameters[self.skew_slice])

    def resistance(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """R, eq. (11), with the friction of the energy's own sub-systems."""
        zero = casadi.SX(self.n_q, self.n_q)
        rates = casadi.SX.sym("rates", self.n_q)
        friction = self.energy.friction(q, rates, parameters[self.energy_slice])
        shares = casadi.substitute(casadi.jacobian(friction, rates), rates, casadi.SX.zeros(self.n_q))
        parts = casadi.diagcat(zero, shares)
        if self.damping is None:
            return parts
        if self.structure == "full":
            return parts + self.damping.matrix(self._state(q, qd), parameters[self.damping_slice])
        place = self.features.expression(q, qd)
        return parts + casadi.diagcat(zero, self.damping.matrix(place, parameters[self.damping_slice]))

    def part_energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> list[EnergyExpressions]:
        """Those of the energy, where it is an interconnection."""
        return self.energy.part_energies(q, qd, parameters[self.energy_slice])

    def port_error(
        self, q: casadi.SX, qd: casadi.SX, qdd: casadi.SX, tau: casadi.SX, parameters: casadi.SX
    ) -> casadi.SX:
        """The error of (12b), (2 n_q,); with a momentum of its own, that of (7a) beside it, (3 n_q,)."""
        if self.transform is None:
            return super().port_error(q, qd, qdd, tau, parameters)
        momentum = self.transformed_momentum(q, qd, parameters)
        rate = casadi.jtimes(momentum, q, qd) + casadi.jtimes(momentum, qd, qdd)
        motion = self.port_form(q, qd, parameters).drift + casadi.vertcat(casadi.SX.zeros(self.n_q), tau)
        inverse = self.inverse_dynamics(q, qd, qdd, parameters) - tau
        return casadi.vertcat(inverse, motion - casadi.vertcat(qd, rate))

    def _state(self, q: casadi.SX, qd: casadi.SX) -> casadi.SX:
        """x for a network: the position, and the velocities in their own scale in place of p."""
        return casadi.vertcat(self.features.expression(q, qd), qd / casadi.DM(self.velocity_scale))


def build(context: Context, options: Options) -> Model:
    """The model; with energies of a basis there is no floor. UserError for sub-systems that cannot be joined."""
    scale, hidden, activation = context.velocity_scale, options.hidden, options.activation
    positions = context.positions
    learned: Model
    if options.energy == "hinged":
        learned = _hinged(context, options)
    elif options.energy == "structured":
        chosen = structured.Options(hidden=hidden, rank=options.rank, activation=activation, potential_hidden=hidden)
        learned = structured.Structured(context.n_q, scale, chosen, positions)
    else:
        learned = Lagrangian(context.basis, context.n_q, hidden=hidden, activation=activation)
    return PortHamiltonian(learned, scale, options, positions)


def _hinged(context: Context, options: Options) -> Model:
    """Two port-Hamiltonian sub-systems, trained before or to be learned, joined by a hinge."""
    if problem := options.parts_problem(context.n_q, [part.model.n_q for part in context.parts]):
        raise UserError(problem)
    alone = replace(options, energy="structured", structure="canonical", momentum_hidden=None)
    bodies = [part.model for part in context.parts]
    bodies = bodies or [build(own, alone) for own in alone_contexts(context, options.length, options.rod_length)]
    for body in bodies:
        q, qd, weights = body.symbols("q", "qd")
        friction = body.friction(q, qd, weights)
        if casadi.depends_on(casadi.jacobian(friction, qd), qd):
            raise UserError(
                f"model.parts = {list(options.parts)}: friction that is not linear in rates has no R, eq. (5)"
            )
    return joined(context, bodies, options.length, options.rod_length, options.frozen)
