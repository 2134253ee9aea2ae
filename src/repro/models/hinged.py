"""A double pendulum made of a learned cart with a rod and a learned free rod, joined by a hinge (section IV)."""

from collections.abc import Sequence

import casadi
import numpy as np

from repro.mechanics.chain import Link
from repro.models.expression import ExpressionModel
from repro.models.interconnection import Interconnection, Joined
from repro.models.model import EnergyExpressions, Model


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
            x, first, across, height, second = casadi.vertsplit(apart)
            return casadi.vertcat(
                x + length * casadi.sin(first) - across + centre * casadi.sin(second),
                up * (length * casadi.cos(first) + centre * casadi.cos(second)) - height,
            )

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
            mass, push = _motion(model, apart[own], rates[own], parameters[weights])
            masses.append(mass)
            pushes.append(push)
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


def _motion(model: Model, q: casadi.SX, qd: casadi.SX, weights: casadi.SX) -> tuple[casadi.SX, casadi.SX]:
    """M and h of M qdd + h = tau, of one body alone."""
    place, rates = casadi.SX.sym("q", model.n_q), casadi.SX.sym("qd", model.n_q)
    mass = casadi.jacobian(model.momentum(place, rates, weights), rates)
    push = model.inverse_dynamics(place, rates, casadi.SX.zeros(model.n_q), weights)
    mass, push = casadi.substitute([mass, push], [place, rates], [q, qd])
    return mass, push
