"""Two uniform rods, one at the end of the other, on a fixed hinge: what the acrobot and the pendubot have in common."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.chain import Link
from repro.mechanics.coordinate import Coordinate, Input, Maths, Rows, Scalars
from repro.mechanics.shapes import Circle, Segment, Shape, Turn
from repro.mechanics.system import States, System


@dataclass(frozen=True)
class TwoLinks(System):
    """Rods of mass m1, m2 and length L1, L2 (kg, m, m/s^2), their absolute angles from upright.

    driven: the joint, 0 or 1, where the torque acts.
    """

    driven: ClassVar[int]
    coordinates = Coordinate("theta1", "rad", True), Coordinate("theta2", "rad", True, absolute=True)
    inputs = (Input("torque", "N m", 1.0),)
    rest_states: ClassVar[States] = {"upright": (0.0, 0.0), "hanging": (math.pi, math.pi)}

    m1: float = 0.2
    m2: float = 0.2
    L1: float = 0.5
    L2: float = 0.5
    g: float = 9.8

    def input_map(self, q: Scalars, m: Maths) -> Rows:
        """A torque at the elbow acts between the two rods."""
        return [[-1.0], [1.0]] if self.driven else [[1.0], [0.0]]

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        first, second = Link.rod(self.m1, self.L1), Link.rod(self.m2, self.L2)
        inner = first.inertia + self.m1 * first.centre**2 + self.m2 * self.L1**2
        outer = second.inertia + self.m2 * second.centre**2
        coupled = self.m2 * self.L1 * second.centre * m.cos(q[0] - q[1])
        return 0.5 * inner * qd[0] ** 2 + 0.5 * outer * qd[1] ** 2 + coupled * qd[0] * qd[1]

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        inner, outer = (self.m1 / 2 + self.m2) * self.L1, self.m2 / 2 * self.L2
        return self.g * (inner * m.cos(q[0]) + outer * m.cos(q[1]))

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The rods on their hinge, and the torque at the driven joint."""
        hinge = (0.0, 0.0)
        elbow = (self.L1 * m.sin(q[0]), self.L1 * m.cos(q[0]))
        tip = (elbow[0] + self.L2 * m.sin(q[1]), elbow[1] + self.L2 * m.cos(q[1]))
        torque = Turn((hinge, elbow)[self.driven], 0.2 * self.L1)
        return [Circle(hinge, 0.06 * self.L1), Segment(hinge, elbow), Segment(elbow, tip), torque]
