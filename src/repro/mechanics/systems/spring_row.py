"""Masses in a row on springs, the first one tied to a wall, with a force on the last one."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Rows, Scalars
from repro.mechanics.shapes import Block, InputArrow, Segment, Shape, Spring
from repro.mechanics.system import System


@dataclass(frozen=True)
class SpringRow(System):
    """n masses m1 (kg) on springs k1 (N/m)."""

    name: ClassVar[str] = "spring_row"
    counts: ClassVar[Mapping[str, int]] = {"n": 8}
    inputs = (Input("force", "N", 5.0),)

    n: int = 3
    m1: float = 0.5
    k1: float = 20.0

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """How far each mass is from its place at rest."""
        return tuple(Coordinate(f"x{number}", "m", False) for number in range(1, self.n + 1))

    def input_map(self, q: Scalars, m: Maths) -> Rows:
        """It moves the last mass."""
        return [*[[0.0]] * (self.n - 1), [1.0]]

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J."""
        return 0.5 * self.m1 * sum(rate**2 for rate in qd)

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Energy of the springs in J."""
        return 0.5 * self.k1 * (q[0] ** 2 + sum((after - before) ** 2 for before, after in pairwise(q)))

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The masses, 1 m apart at rest, their springs, the wall and the force."""
        places = [(float(number) + value, 0.0) for number, value in enumerate(q, start=1)]
        springs = [Spring(*ends) for ends in pairwise([(0.0, 0.0), *places])]
        masses = [Block(place, (0.15, 0.15)) for place in places]
        return [Segment((0.0, -0.3), (0.0, 0.3), solid=False), *springs, *masses, InputArrow(places[-1], (1.0, 0.0))]
