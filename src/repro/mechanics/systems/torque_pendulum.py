"""A uniform rod on a fixed hinge that a motor turns, too weak to lift it."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Circle, Segment, Shape, Turn
from repro.mechanics.system import States, System


@dataclass(frozen=True)
class TorquePendulum(System):
    """A rod of mass m1 and length L1 (kg, m, m/s^2), its angle from upright, and a torque on the hinge."""

    name: ClassVar[str] = "torque_pendulum"
    coordinates = (Coordinate("theta", "rad", True),)
    inputs = (Input("torque", "N m", 1.0),)
    rest_states: ClassVar[States] = {"upright": (0.0,), "hanging": (math.pi,)}

    m1: float = 1.0
    L1: float = 1.0
    g: float = 9.8

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        return self.m1 * self.L1**2 / 6 * qd[0] ** 2

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J."""
        return self.m1 * self.g * self.L1 / 2 * m.cos(q[0])

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The rod on its hinge, and the torque."""
        tip = (self.L1 * m.sin(q[0]), self.L1 * m.cos(q[0]))
        return [Circle((0.0, 0.0), 0.06), Segment((0.0, 0.0), tip), Turn((0.0, 0.0), 0.15)]
