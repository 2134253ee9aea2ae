"""A mass on a stiffening spring, with a force on it: the link that chains are made of."""

from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Block, InputArrow, Point, Segment, Shape, Spring
from repro.mechanics.system import System


@dataclass(frozen=True)
class SpringLink(System):
    """Mass m1 (kg) at the end of a spring with force k1 s + k3 s^3 (N/m, N/m^3) that hangs on a wall."""

    name: ClassVar[str] = "link"
    coordinates = (Coordinate("x", "m", False),)
    inputs = (Input("force", "N", 5.0),)
    reset_ranges = (((0.0, 0.0), (-1.0, 1.0)),)

    m1: float = 0.5
    k1: float = 20.0
    k3: float = 40.0

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        return 0.5 * self.m1 * qd[0] ** 2

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Energy of the spring in J."""
        return 0.5 * self.k1 * q[0] ** 2 + 0.25 * self.k3 * q[0] ** 4

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The mass, and the spring to a wall 1 m away at rest."""
        at, wall = (q[0], 0.0), (-1.0, 0.0)
        return [
            Segment((-1.0, -0.2), (-1.0, 0.2), solid=False),
            Spring(wall, at),
            Block(at, (0.1, 0.1)),
            InputArrow(at, (1.0, 0.0)),
        ]

    def body_points(self, q: Scalars, m: Maths) -> list[Point]:
        """World points [x, y] in m of the mass and of the wall, 1 m away at rest."""
        return [[q[0], 0.0 * q[0]], [-1.0 + 0.0 * q[0], 0.0 * q[0]]]
