"""The single inverted pendulum of eq. (13): a cart and a point mass at the end of a massless pole."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.system import Coordinate, System


@dataclass(frozen=True)
class SinglePendulum(System):
    """Cart and point mass, constants of Table I (kg, m, m/s^2)."""

    name: ClassVar[str] = "sip"
    coordinates: ClassVar[tuple[Coordinate, ...]] = (Coordinate("x", "m", False), Coordinate("theta", "rad", True))

    m0: float = 0.6
    m1: float = 0.2
    L1: float = 0.5
    g: float = 9.8

    @property
    def l1(self) -> float:
        """Distance from the joint to the centre of mass in m."""
        return self.L1

    @property
    def inertia(self) -> float:
        """Inertia about the centre of mass in kg m^2."""
        return 0.0

    def kinetic(self, q: Sequence[Any], qd: Sequence[Any], m: Any) -> Any:
        """Kinetic energy in J (section V-A)."""
        (_, theta), (xd, thetad) = q, qd
        return (
            0.5 * (self.m0 + self.m1) * xd**2
            + self.m1 * self.l1 * xd * thetad * m.cos(theta)
            + 0.5 * (self.m1 * self.l1**2 + self.inertia) * thetad**2
        )

    def potential(self, q: Sequence[Any], m: Any) -> Any:
        """Potential energy in J (section V-A, signed by the reading)."""
        return self.up * self.m1 * self.g * self.l1 * m.cos(q[1])

    def body_points(self, q: Sequence[Any], m: Any) -> list[list[Any]]:
        """World points [x, y] in m of the cart and the tip of the pole."""
        x, theta = q
        return [[x, 0.0 * x], [x + self.L1 * m.sin(theta), self.up * self.L1 * m.cos(theta)]]
