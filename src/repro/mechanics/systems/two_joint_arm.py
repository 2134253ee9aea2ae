"""A robot arm of two rods with a motor in each joint."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Circle, Segment, Shape, Turn
from repro.mechanics.system import States, System


@dataclass(frozen=True)
class TwoJointArm(System):
    """Rods of mass m1, m2 and length L1, L2 (kg, m, m/s^2) in a vertical plane.

    The angle of the shoulder is measured from upright, that of the elbow from the first rod.
    """

    name: ClassVar[str] = "two_joint_arm"
    coordinates = Coordinate("shoulder", "rad", True), Coordinate("elbow", "rad", True)
    inputs = Input("shoulder_torque", "N m", 10.0), Input("elbow_torque", "N m", 4.0)
    rest_states: ClassVar[States] = {"hanging": (math.pi, 0.0), "upright": (0.0, 0.0), "home": (math.pi / 2, 0.0)}

    m1: float = 1.0
    m2: float = 0.8
    L1: float = 0.4
    L2: float = 0.3
    g: float = 9.8

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        first, second = qd[0], qd[0] + qd[1]
        inner = (self.m1 / 3 + self.m2) * self.L1**2
        coupled = self.m2 * self.L1 * self.L2 / 2 * m.cos(q[1])
        return 0.5 * inner * first**2 + self.m2 * self.L2**2 / 6 * second**2 + coupled * first * second

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        inner, outer = (self.m1 / 2 + self.m2) * self.L1, self.m2 / 2 * self.L2
        return self.g * (inner * m.cos(q[0]) + outer * m.cos(q[0] + q[1]))

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The rods on their hinge, and the torques."""
        base, end = (0.0, 0.0), q[0] + q[1]
        elbow = (self.L1 * m.sin(q[0]), self.L1 * m.cos(q[0]))
        tip = (elbow[0] + self.L2 * m.sin(end), elbow[1] + self.L2 * m.cos(end))
        torques = Turn(base, 0.1, 0), Turn(elbow, 0.08, 1)
        return [Circle(base, 0.04), Segment(base, elbow), Segment(elbow, tip), *torques]
