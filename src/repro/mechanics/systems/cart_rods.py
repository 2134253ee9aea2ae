"""A cart with any number of equal rods: the single and the double pendulum are its first two."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from repro.mechanics.chain import Chain, Link


@dataclass(frozen=True)
class MultiplePendulum(Chain):
    """Cart and n rods of mass m1 and length L1 each (kg, m, m/s^2)."""

    name: ClassVar[str] = "cart_rods"
    counts: ClassVar[Mapping[str, int]] = {"n": 8}

    n: int = 3
    m1: float = 0.2
    L1: float = 0.5

    @property
    def links(self) -> tuple[Link, ...]:
        """The rods."""
        return (Link.rod(self.m1, self.L1),) * self.n
