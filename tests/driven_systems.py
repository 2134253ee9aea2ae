"""Systems for tests: several inputs whose directions turn, and one torque between two links."""

from dataclasses import dataclass
from typing import ClassVar

from repro.mechanics.chain import Link
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.inputs import Input
from repro.mechanics.shapes import Segment
from repro.mechanics.system import System


@dataclass(frozen=True)
class TwoRotors(System):
    """A body in the plane between two rotors, whose thrusts go along its own vertical: B depends on theta."""

    name: ClassVar[str] = "two_rotors"

    mass: float = 0.5
    inertia: float = 0.01
    arm: float = 0.2
    g: float = 9.8

    @property
    def coordinates(self):
        return Coordinate("x", "m", False, cyclic=True), Coordinate("y", "m", False), Coordinate("theta", "rad", True)

    @property
    def inputs(self):
        return Input("left", "N", 6.0), Input("right", "N", 6.0)

    def input_map(self, q, m):
        across, along = -m.sin(q[2]), m.cos(q[2])
        return [[across, across], [along, along], [-self.arm, self.arm]]

    def kinetic(self, q, qd, m):
        return 0.5 * self.mass * (qd[0] ** 2 + qd[1] ** 2) + 0.5 * self.inertia * qd[2] ** 2

    def potential(self, q, m):
        return self.mass * self.g * q[1]

    def shapes(self, q, m):
        right, up = self.arm * m.cos(q[2]), self.arm * m.sin(q[2])
        return [Segment([q[0] - right, q[1] - up], [q[0] + right, q[1] + up])]


@dataclass(frozen=True)
class ElbowPendulum(System):
    """Two rods on a fixed hinge, absolute angles from upright, and a torque between them (the acrobot)."""

    name: ClassVar[str] = "elbow_pendulum"

    g: float = 9.8

    @property
    def coordinates(self):
        return Coordinate("theta1", "rad", True), Coordinate("theta2", "rad", True, absolute=True)

    @property
    def inputs(self):
        return (Input("torque", "N m", 1.0),)

    def input_map(self, q, m):
        return [[-1.0], [1.0]]

    def kinetic(self, q, qd, m):
        rod = Link.rod(0.2, 0.5)
        own = rod.inertia + rod.mass * rod.centre**2
        first = 0.5 * (own + rod.mass * rod.length**2) * qd[0] ** 2
        coupling = rod.mass * rod.length * rod.centre * qd[0] * qd[1] * m.cos(q[0] - q[1])
        return first + 0.5 * own * qd[1] ** 2 + coupling

    def potential(self, q, m):
        rod = Link.rod(0.2, 0.5)
        return self.g * rod.mass * ((rod.centre + rod.length) * m.cos(q[0]) + rod.centre * m.cos(q[1]))

    def shapes(self, q, m):
        elbow = [0.5 * m.sin(q[0]), 0.5 * m.cos(q[0])]
        tip = [elbow[0] + 0.5 * m.sin(q[1]), elbow[1] + 0.5 * m.cos(q[1])]
        return [Segment([0.0 * q[0], 0.0 * q[0]], elbow), Segment(elbow, tip)]
