"""A double pendulum made of a learned cart with a rod and a learned free rod, joined by a hinge (section IV)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import casadi
import numpy as np

from repro.errors import UserError
from repro.mechanics.chain import Link, LinkAngles
from repro.mechanics.coordinate import Coordinate
from repro.models.bases import rigid_body
from repro.models.context import Context
from repro.models.expression import ExpressionModel
from repro.models.interconnection import Interconnection, Joined
from repro.models.lagrangian import Lagrangian
from repro.models.model import EnergyExpressions, Model
from repro.models.model_options import ModelOptions, Rod
from repro.plugins.options import Positive


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=hinged: what each is stands in conf/model/hinged.yaml."""

    parts: tuple[str, ...] = ("cart_rod", "free_rod")
    frozen: bool = True
    rod: Rod = "part"
    length: Positive = 0.5
    rod_length: Positive = 0.5
    gravity: Positive = 9.8

    def is_linear(self, basis_is_linear: bool) -> bool:
        """What is fitted beside frozen parts are coefficients, on any basis."""
        return self.frozen

    def parts_problem(self, n_q: int, part_sizes: Sequence[int]) -> str | None:
        """A cart with a rod, then with rod `part` a free rod, to be joined on a double pendulum."""
        needed, words = [2], "a cart with a rod alone, as model.parts=[cart_rod]"
        if self.rod == "part":
            needed, words = [2, 3], "a cart with a rod and a free rod, as model.parts=[cart_rod, free_rod]"
        if n_q == 3 and list(part_sizes) == needed:
            return None
        return f"model.parts = {list(self.parts)}: model.rod={self.rod} on system=dip takes {words}"


class Hinged(Interconnection):
    """(x, theta1) of a cart with a rod, and (x, y, theta2) of a free rod whose end is hinged to the end of the first.

    length: of the first rod, to the hinge; centre: from the hinge to the centre of the free rod (m); up: cosine of the
    upright angle. The hinge keeps its two ends together and does no work.
    """

    def __init__(
        self,
        cart: Model,
        rod: Model,
        *,
        length: float,
        centre: float,
        up: float = 1.0,
        trained: np.ndarray | None = None,
        frozen: bool = True,
    ) -> None:
        def place(q: casadi.SX) -> casadi.SX:
            across = q[0] + length * casadi.sin(q[1]) + centre * casadi.sin(q[2])
            return casadi.vertcat(across, up * (length * casadi.cos(q[1]) + centre * casadi.cos(q[2])), q[2])

        def gap(apart: casadi.SX) -> casadi.SX:
            hinged = place(casadi.vertcat(apart[:2], apart[4]))
            return hinged[:2] - apart[2:4]

        super().__init__([Joined(cart, lambda q: q[:2]), Joined(rod, place)], 3, trained, frozen)
        self.place, self.gap = place, gap

    def acceleration(self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """qdd (3,) of the two bodies under the hinge's force, as `constrained` gives it."""
        apart = self.constrained(q, qd, tau, parameters)[0]
        return casadi.vertcat(apart[:2], apart[4])

    def constrained(
        self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX
    ) -> tuple[casadi.SX, casadi.SX]:
        """Accelerations (5,) of both bodies and the hinge's force (2,), the multipliers, from

        `[M_S 0 G_S'; 0 M_R G_R'; G_S G_R 0] [qdd_S; qdd_R; -lambda] = [tau_S - h_S; tau_R - h_R; -Gdot qd]`.
        """
        apart, rates = casadi.SX.sym("apart", 5), casadi.SX.sym("rates", 5)
        masses, pushes = [], []
        ends = ((self.parts[0].model, slice(0, 2)), (self.parts[1].model, slice(2, 5)))
        for (model, own), weights in zip(ends, self.slices, strict=True):
            masses.append(model.mass_matrix(apart[own], rates[own], parameters[weights]))
            still = casadi.SX.zeros(model.n_q)
            pushes.append(model.inverse_dynamics(apart[own], rates[own], still, parameters[weights]))
        gap = self.gap(apart)
        joint = casadi.jacobian(gap, apart)
        turning = casadi.jtimes(joint @ rates, apart, rates)
        matrix = casadi.vertcat(
            casadi.horzcat(casadi.diagcat(*masses), joint.T), casadi.horzcat(joint, casadi.SX(2, 2))
        )
        # M > 0 and a full-rank G make every pivot of LDL' non-zero in this order
        right = casadi.vertcat(tau[:2], casadi.SX.zeros(2), tau[2], casadi.SX.zeros(2)) - casadi.vertcat(
            *pushes, turning
        )
        place = self.place(q)
        here = [casadi.vertcat(q[:2], place), casadi.vertcat(qd[:2], casadi.jtimes(place, q, qd))]
        matrix, right = casadi.substitute([matrix, right], [apart, rates], here)
        solution = casadi.ldl_solve(right, *casadi.ldl(matrix))
        return solution[:5], -solution[5:]


class RodOfUnknownMass(ExpressionModel):
    """A uniform rod of known length: mass is all that there is to learn; parameters: [mass in kg]."""

    n_parameters = 1
    n_q = 3
    coefficient_names = ("mass",)

    def __init__(self, length: float, gravity: float) -> None:
        self.unit, self.gravity = Link.rod(1.0, length), gravity

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No mass."""
        return np.zeros((len(generators), 1))

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T and V of the rod."""
        kinetic = 0.5 * (qd[0] ** 2 + qd[1] ** 2) + 0.5 * self.unit.inertia * qd[2] ** 2
        return EnergyExpressions(parameters[0] * kinetic, parameters[0] * self.gravity * q[1])


def build(context: Context, options: Options) -> Model:
    """The joined model; UserError for parts that do not fit together."""
    rod = options.rod
    if problem := options.parts_problem(context.n_q, [part.model.n_q for part in context.parts]):
        raise UserError(problem)
    second: Model
    if rod == "part":
        second = context.parts[1].model
    elif rod == "mass":
        second = RodOfUnknownMass(options.rod_length, options.gravity)
    else:
        second = Lagrangian(rigid_body, 3)
    return joined(context, [context.parts[0].model, second], options.length, options.rod_length, options.frozen)


def joined(context: Context, bodies: Sequence[Model], length: float, rod_length: float, frozen: bool) -> Model:
    """A cart with a rod of `length` and a free rod of `rod_length` (m), hinged; trained parts bring their weights."""
    up = context.system.up if isinstance(context.system, LinkAngles) else 1.0
    weights = np.concatenate([part.parameters for part in context.parts], axis=1) if context.parts else None
    return Hinged(*bodies, length=length, centre=rod_length / 2, up=up, trained=weights, frozen=frozen)


def alone_contexts(context: Context, length: float, rod_length: float) -> Iterator[Context]:
    """The motion of a double pendulum as that of its cart with a rod, and of its second rod as a free one."""
    q, qd = context.q, context.qd
    yield replace(
        context, coordinates=context.coordinates[:2], q=q[..., :2], qd=qd[..., :2], first_qd=context.first_qd[..., :2]
    )
    arms = np.array([length, rod_length / 2])
    right, up = arms * np.sin(q[..., 1:]), arms * np.cos(q[..., 1:])
    place = np.stack([q[..., 0] + right.sum(-1), up.sum(-1), q[..., 2]], axis=-1)
    rates = np.stack([qd[..., 0] + (up * qd[..., 1:]).sum(-1), -(right * qd[..., 1:]).sum(-1), qd[..., 2]], axis=-1)
    free = (Coordinate("x", "m", False, cyclic=True), Coordinate("y", "m", False), Coordinate("theta", "rad", True))
    yield replace(context, coordinates=free, q=place, qd=rates, first_qd=rates)
