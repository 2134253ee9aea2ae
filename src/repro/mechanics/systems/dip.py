"""The double inverted pendulum of section V-B: a cart and two uniform rods."""

from dataclasses import dataclass
from typing import Any, ClassVar

from repro.mechanics.chain import Chain, Link
from repro.mechanics.coordinate import Maths, Scalars
from repro.mechanics.system import System
from repro.mechanics.system_options import Reading
from repro.mechanics.systems.sip_rod import SinglePendulumRod


@dataclass(frozen=True)
class DoublePendulum(Chain):
    """Cart and two rods; masses and L1 of Table I, L2 as in do-mpc's example (kg, m, m/s^2).

    The printed reading keeps the two misprints of section V-B: l1 for L1 in the vertical velocity of the second rod,
    and a bracket that takes l2 cos(theta2) into the argument of the first cosine.
    """

    name: ClassVar[str] = "dip"

    m1: float = 0.2
    m2: float = 0.2
    L1: float = 0.5
    L2: float = 0.5

    @property
    def links(self) -> tuple[Link, ...]:
        """Two rods."""
        return Link.rod(self.m1, self.L1), Link.rod(self.m2, self.L2)

    @property
    def first_part(self) -> System:
        """The cart with the first rod."""
        return SinglePendulumRod(m0=self.m0, m1=self.m1, L1=self.L1, g=self.g, reading=self.reading)

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J; printed: with (l1 thetad1 sin(theta1) + l2 thetad2 sin(theta2))^2 in T_p2."""
        right = super().kinetic(q, qd, m)
        if self.reading == Reading.PHYSICAL:
            return right
        first, second = (link.centre * qd[i] * m.sin(q[i]) for i, link in enumerate(self.links, start=1))
        whole = self.L1 * qd[1] * m.sin(q[1])
        return right + 0.5 * self.m2 * ((first + second) ** 2 - (whole + second) ** 2)

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J; printed: - m1 g l1 cos(theta1) - m2 g (L1 cos(theta1 + l2 cos(theta2)))."""
        if self.reading == Reading.PHYSICAL:
            return super().potential(q, m)
        first, second = self.links
        outer = self.L1 * m.cos(q[1] + second.centre * m.cos(q[2]))
        return -self.m1 * self.g * first.centre * m.cos(q[1]) - self.m2 * self.g * outer
