"""The single pendulum with its cart on a slope."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Block, InputArrow, Segment, Shape
from repro.mechanics.system import States, System


@dataclass(frozen=True)
class CartOnSlope(System):
    """A cart m0 on a track that rises by the angle `slope` (rad, of any sign), and a point mass m1 on a pole of L1.

    kg, m, m/s^2; the pole's angle is measured from upright.
    """

    name: ClassVar[str] = "cart_on_slope"
    signed: ClassVar[tuple[str, ...]] = ("slope",)
    coordinates = Coordinate("x", "m", False), Coordinate("theta", "rad", True)
    inputs = (Input("force", "N", 5.0),)
    rest_states: ClassVar[States] = {"upright": (0.0, 0.0), "hanging": (0.0, math.pi)}

    m0: float = 0.6
    m1: float = 0.2
    L1: float = 0.5
    slope: float = 0.2
    g: float = 9.8

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        coupled = self.m1 * self.L1 * m.cos(q[1] + self.slope) * qd[0] * qd[1]
        return 0.5 * (self.m0 + self.m1) * qd[0] ** 2 + 0.5 * self.m1 * self.L1**2 * qd[1] ** 2 + coupled

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        lift = (self.m0 + self.m1) * math.sin(self.slope) * q[0]
        return self.g * (lift + self.m1 * self.L1 * m.cos(q[1]))

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The cart on its track, the pole and the force."""
        along = (math.cos(self.slope), math.sin(self.slope))
        cart = (q[0] * along[0], q[0] * along[1])
        tip = (cart[0] + self.L1 * m.sin(q[1]), cart[1] + self.L1 * m.cos(q[1]))
        size = (0.28 * self.L1, 0.1 * self.L1)
        return [Block(cart, size, self.slope, wheels=True), Segment(cart, tip), InputArrow(cart, along)]
