"""The single inverted pendulum of eq. (13): a cart and a point mass at the end of a massless pole."""

from dataclasses import dataclass
from typing import ClassVar

from repro.mechanics.chain import Chain, Link


@dataclass(frozen=True)
class SinglePendulum(Chain):
    """Cart and point mass, constants of Table I (kg, m, m/s^2)."""

    name: ClassVar[str] = "sip"

    m1: float = 0.2
    L1: float = 0.5

    @property
    def links(self) -> tuple[Link, ...]:
        """A massless pole with a point mass at its end."""
        return (Link(self.m1, self.L1, self.L1, 0.0),)
