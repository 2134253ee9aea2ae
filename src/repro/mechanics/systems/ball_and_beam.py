"""A ball that rolls on a beam, which a motor tilts."""

from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Rows, Scalars
from repro.mechanics.shapes import Circle, Segment, Shape, Turn
from repro.mechanics.system import Range, System


@dataclass(frozen=True)
class BallAndBeam(System):
    """A solid ball of mass m1 and radius r1 on a beam of inertia J0 and half its length L (kg, m, kg m^2, m/s^2).

    The beam turns about its middle; the ball rolls without slip at the height of the axis.
    """

    name: ClassVar[str] = "ball_and_beam"
    coordinates = Coordinate("x", "m", False), Coordinate("alpha", "rad", True)
    inputs = (Input("torque", "N m", 1.0),)

    m1: float = 0.2
    r1: float = 0.02
    J0: float = 0.1
    L: float = 0.5
    g: float = 9.8

    def input_map(self, q: Scalars, m: Maths) -> Rows:
        """It tilts the beam."""
        return [[0.0], [1.0]]

    @property
    def reset_ranges(self) -> tuple[tuple[Range, Range], ...]:
        """The ball on the beam, the beam near level."""
        return ((-0.8 * self.L, 0.8 * self.L), (-0.5, 0.5)), ((-0.5, 0.5), (-1.0, 1.0))

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J; rolling adds 2/5 of the ball's mass along the beam."""
        return 0.7 * self.m1 * qd[0] ** 2 + 0.5 * (self.J0 + self.m1 * q[0] ** 2) * qd[1] ** 2

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        return self.m1 * self.g * q[0] * m.sin(q[1])

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The beam on its axis, the ball drawn larger than it is, and the torque."""
        along, size = (m.cos(q[1]), m.sin(q[1])), 2 * self.r1
        left, right = ([sign * self.L * part for part in along] for sign in (-1, 1))
        ball = (q[0] * along[0] - size * along[1], q[0] * along[1] + size * along[0])
        return [
            Circle((0.0, 0.0), 0.02),
            Segment(left, right),
            Circle(ball, size),
            Turn((0.0, 0.0), 0.1, clockwise=False),
        ]
