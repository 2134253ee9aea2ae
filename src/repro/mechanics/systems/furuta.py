"""The rotary pendulum of Furuta: a motor turns an arm, and a rod swings at its end."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Circle, Segment, Shape, Turn
from repro.mechanics.system import States, System


@dataclass(frozen=True)
class FurutaPendulum(System):
    """An arm of length r with inertia J0 about the motor, and a rod of mass m1 and length L1 (kg m^2, m, kg, m/s^2).

    The rod turns about the arm, its angle measured from upright; a picture shows it at an angle from above.
    """

    name: ClassVar[str] = "furuta"
    coordinates = Coordinate("phi", "rad", True, cyclic=True), Coordinate("theta", "rad", True)
    inputs = (Input("torque", "N m", 0.3),)
    rest_states: ClassVar[States] = {"upright": (0.0, 0.0), "hanging": (0.0, math.pi)}

    J0: float = 0.02
    r: float = 0.25
    m1: float = 0.2
    L1: float = 0.5
    g: float = 9.8

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        phid, thetad = qd
        inertia, moment = self.m1 * self.L1**2 / 3, self.m1 * self.L1 / 2
        arm = 0.5 * (self.J0 + self.m1 * self.r**2 + inertia * m.sin(q[1]) ** 2) * phid**2
        return arm + 0.5 * inertia * thetad**2 + moment * self.r * m.cos(q[1]) * phid * thetad

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        return self.m1 * self.g * self.L1 / 2 * m.cos(q[1])

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """Arm and rod, seen from the side and a little from above."""
        (phi, theta), (r, length) = q, (self.r, self.L1)
        across, up = length * m.sin(theta), length * m.cos(theta)
        elbow = _seen(r * m.cos(phi), r * m.sin(phi), 0.0)
        tip = _seen(r * m.cos(phi) - across * m.sin(phi), r * m.sin(phi) + across * m.cos(phi), up)
        return [Circle((0.0, 0.0), 0.2 * r), Segment((0.0, 0.0), elbow), Segment(elbow, tip), Turn((0.0, 0.0), r / 2)]


def _seen(x: Any, y: Any, z: Any) -> tuple[Any, Any]:
    """Where a point in space is drawn; y goes away from the eye."""
    return x, z + 0.4 * y
