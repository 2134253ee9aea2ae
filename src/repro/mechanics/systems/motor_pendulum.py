"""An electric motor that swings a rod: a current and an angle in one Lagrangian."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Circle, Segment, Shape, Turn
from repro.mechanics.system import States, System


@dataclass(frozen=True)
class MotorPendulum(System):
    """A direct-current motor with inductance Li (H) and motor constant ki (N m/A, V s/rad), and a rod m1 of length L1.

    kg, m, m/s^2. The rate of the charge is the current; its friction, damping[0], is the resistance in ohm. The term
    ki theta i of L gives the torque ki i and the voltage ki thetad, which exchange power without storing energy: H is
    that of the magnetic field and of the rod.
    """

    name: ClassVar[str] = "motor_pendulum"
    coordinates = Coordinate("charge", "C", False, cyclic=True), Coordinate("theta", "rad", True)
    inputs = (Input("voltage", "V", 6.0),)
    rest_states: ClassVar[States] = {"upright": (0.0, 0.0), "hanging": (0.0, math.pi)}

    Li: float = 0.05
    ki: float = 0.3
    m1: float = 0.2
    L1: float = 0.5
    g: float = 9.8

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Energy in J of the magnetic field and of the rod."""
        return 0.5 * self.Li * qd[0] ** 2 + self.m1 * self.L1**2 / 6 * qd[1] ** 2

    def coupling(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """The term of the motor in L, in J."""
        return self.ki * q[1] * qd[0]

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J of the rod."""
        return self.m1 * self.g * self.L1 / 2 * m.cos(q[1])

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The motor, the rod, and the voltage."""
        tip = (self.L1 * m.sin(q[1]), self.L1 * m.cos(q[1]))
        return [Circle((0.0, 0.0), 0.12), Segment((0.0, 0.0), tip), Turn((0.0, 0.0), 0.18)]
