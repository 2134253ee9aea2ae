"""The single inverted pendulum with a uniform rod: what is left of the double pendulum without its second link."""

from dataclasses import dataclass
from typing import ClassVar

from repro.mechanics.systems.sip import SinglePendulum


@dataclass(frozen=True)
class SinglePendulumRod(SinglePendulum):
    """Cart and uniform rod, constants of Table I."""

    name: ClassVar[str] = "sip_rod"

    @property
    def l1(self) -> float:
        """Distance from the joint to the centre of mass in m."""
        return self.L1 / 2

    @property
    def inertia(self) -> float:
        """Inertia about the centre of mass in kg m^2."""
        return self.m1 * self.L1**2 / 12
