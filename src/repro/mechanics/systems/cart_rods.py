"""A cart with any number of equal rods: the single and the double pendulum are its first two."""

from dataclasses import dataclass
from typing import ClassVar

from repro.errors import UserError
from repro.mechanics.chain import Chain, Link

MOST = 8


@dataclass(frozen=True)
class MultiplePendulum(Chain):
    """Cart and n rods of mass m1 and length L1 each (kg, m, m/s^2); UserError for n outside 1..8."""

    name: ClassVar[str] = "cart_rods"

    n: int = 3
    m1: float = 0.2
    L1: float = 0.5

    def __post_init__(self) -> None:
        if self.n != int(self.n) or not 1 <= self.n <= MOST:
            raise UserError(f"n = {self.n}: a pendulum has 1 to {MOST} links")
        object.__setattr__(self, "n", int(self.n))
        super().__post_init__()

    @property
    def links(self) -> tuple[Link, ...]:
        """The rods."""
        return (Link.rod(self.m1, self.L1),) * self.n
