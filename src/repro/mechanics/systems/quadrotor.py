"""A planar quadrotor: a body between two rotors whose thrusts go along its own vertical."""

from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Rows, Scalars
from repro.mechanics.shapes import Block, InputArrow, Segment, Shape
from repro.mechanics.system import States, System


@dataclass(frozen=True)
class PlanarQuadrotor(System):
    """A body of mass m1 and inertia J1, rotors at the distance L from its centre (kg, kg m^2, m, m/s^2)."""

    name: ClassVar[str] = "quadrotor"
    coordinates = (
        Coordinate("x", "m", False, cyclic=True),
        Coordinate("y", "m", False),
        Coordinate("theta", "rad", True, cyclic=True),
    )
    inputs = Input("left_thrust", "N", 6.0), Input("right_thrust", "N", 6.0)
    rest_states: ClassVar[States] = {"hover": (0.0, 0.0, 0.0)}

    m1: float = 0.5
    J1: float = 0.01
    L: float = 0.2
    g: float = 9.8

    def input_map(self, q: Scalars, m: Maths) -> Rows:
        """Both push along the body's vertical, and turn it against each other."""
        across, up = -m.sin(q[2]), m.cos(q[2])
        return [[across, across], [up, up], [-self.L, self.L]]

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        return 0.5 * self.m1 * (qd[0] ** 2 + qd[1] ** 2) + 0.5 * self.J1 * qd[2] ** 2

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        return self.m1 * self.g * q[1]

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The body, its rotors and their thrusts."""
        x, y, theta = q
        right, up = (m.cos(theta), m.sin(theta)), (-m.sin(theta), m.cos(theta))
        first, second = ((x + side * right[0], y + side * right[1]) for side in (-self.L, self.L))
        hub = Block((x, y), (0.3 * self.L, 0.12 * self.L), theta)
        rotors = [Block(end, (0.4 * self.L, 0.04 * self.L), theta) for end in (first, second)]
        return [Segment(first, second), hub, *rotors, InputArrow(first, up, 0), InputArrow(second, up, 1)]
