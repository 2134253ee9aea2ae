"""The single inverted pendulum with a uniform rod: what is left of the double pendulum without its second link."""

from dataclasses import dataclass
from typing import ClassVar

from repro.mechanics.chain import Chain, Link


@dataclass(frozen=True)
class SinglePendulumRod(Chain):
    """Cart and uniform rod, constants of Table I (kg, m, m/s^2)."""

    name: ClassVar[str] = "sip_rod"

    m1: float = 0.2
    L1: float = 0.5

    @property
    def links(self) -> tuple[Link, ...]:
        """One rod."""
        return (Link.rod(self.m1, self.L1),)
