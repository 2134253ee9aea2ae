"""A free uniform rod in the plane, with a force and a torque on it: the second link of the double pendulum, alone."""

from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.chain import Link, LinkAngles
from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Segment, Shape
from repro.mechanics.system import TURN


@dataclass(frozen=True)
class FreeRod(LinkAngles):
    """A rod of mass m2 and length L2 (kg, m, m/s^2): its centre, y up whatever the reading, and its angle as a link.

    V = m2 g y. Both components of the force and the torque are inputs.
    """

    name: ClassVar[str] = "rod"
    coordinates = (
        Coordinate("x", "m", False, cyclic=True),
        Coordinate("y", "m", False),
        Coordinate("theta", "rad", True),
    )
    inputs = Input("force_x", "N", 5.0), Input("force_y", "N", 5.0), Input("torque", "N m", 5.0)
    reset_ranges = ((0.0, 0.0), (-1.0, 1.0)), ((0.0, 0.0), (-1.0, 1.0)), (TURN, (-3.0, 3.0))

    m2: float = 0.2
    L2: float = 0.5
    g: float = 9.8

    @property
    def link(self) -> Link:
        """The rod as a link that would turn about one of its ends."""
        return Link.rod(self.m2, self.L2)

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        xd, yd, rate = qd
        return 0.5 * self.link.mass * (xd**2 + yd**2) + 0.5 * self.link.inertia * rate**2

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        return self.link.mass * self.g * q[1]

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The rod."""
        x, y, angle = q
        right, up = self.link.centre * m.sin(angle), self.up * self.link.centre * m.cos(angle)
        return [Segment([x - right, y - up], [x + right, y + up])]
