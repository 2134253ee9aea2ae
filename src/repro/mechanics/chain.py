"""Links whose absolute angles follow a reading of the paper's conventions, and a cart that carries a chain of them.

T and V of every pendulum of the paper.
"""

import math
from abc import abstractmethod
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any, ClassVar

from repro.mechanics.coordinate import Coordinate, Input, Maths, Scalars
from repro.mechanics.shapes import Block, InputArrow, Segment, Shape
from repro.mechanics.system import States, System
from repro.mechanics.system_options import Reading

CART = (0.28, 0.1)  # half its width and height as drawn, in parts of the first link's length


@dataclass(frozen=True)
class LinkAngles(System):
    """The reading fixes where a link's angle is zero: `physical` upright, `printed` hanging (as in eq. 13).

    Viscous friction acts on the rates of the joints, or of the angles themselves where damping_frame is `absolute`. A
    coefficient of a link at angle th is (1 + damping_growth sin(th)^2) times as large.
    """

    settings: ClassVar[tuple[str, ...]] = (*System.settings, "reading", "damping_frame", "damping_growth")

    reading: Reading = Reading.PHYSICAL
    damping_frame: str = "relative"
    damping_growth: float = 0.0

    @property
    def up(self) -> float:
        """Cosine of the upright angle: 1 where angles are measured from upright, -1 where from hanging."""
        return 1.0 if self.reading == Reading.PHYSICAL else -1.0

    @property
    def rest_states(self) -> States:
        """All links up, and all links down."""
        up, down = (0.0, math.pi) if self.up > 0 else (math.pi, 0.0)
        return {
            name: tuple(angle if coordinate.is_angle else 0.0 for coordinate in self.coordinates)
            for name, angle in (("upright", up), ("hanging", down))
        }

    @property
    def jointed(self) -> tuple[int, ...]:
        """Positions of the links whose friction acts on their rate relative to that of the link before."""
        return super().jointed if self.damping_frame == "relative" else ()

    def growth(self, i: int, q: Scalars, m: Maths) -> Any:
        """Factor of the viscous coefficient of coordinate i at q."""
        return 1 + self.damping_growth * m.sin(q[i]) ** 2 if self.damping_growth and i in self.angles else 1.0


@dataclass(frozen=True)
class Link:
    """One rigid link: mass (kg), length and distance from joint to centre of mass (m), inertia about that (kg m^2)."""

    mass: float
    length: float
    centre: float
    inertia: float

    @classmethod
    def rod(cls, mass: float, length: float) -> "Link":
        """A uniform rod."""
        return cls(mass, length, length / 2, mass * length**2 / 12)


@dataclass(frozen=True)
class Chain(LinkAngles):
    """Cart and links, each at the end of the one before; link angles are absolute.

    With a_ij the arm of angle j at the centre of mass of link i (the length of link j < i, the centre distance of i),

        T = m/2 xd^2 + sum_j h_j xd thd_j cos(th_j) + 1/2 sum_jk I_jk thd_j thd_k cos(th_j - th_k),
        V = up g sum_j h_j cos(th_j),    h_j = sum_i m_i a_ij,    I_jk = sum_i m_i a_ij a_ik + delta_jk J_j.
    """

    inputs = (Input("force", "N", 5.0),)

    m0: float = 0.6
    g: float = 9.8

    @property
    @abstractmethod
    def links(self) -> tuple[Link, ...]:
        """The links from the cart outwards."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The cart's position and the angle of every link."""
        numbers = [""] if len(self.links) == 1 else range(1, len(self.links) + 1)
        cart = Coordinate("x", "m", False, cyclic=True)
        links = (Coordinate(f"theta{n}", "rad", True, absolute=i > 0) for i, n in enumerate(numbers))
        return (cart, *links)

    def kinetic(self, q: Scalars, qd: Scalars, m: Maths) -> Any:
        """Kinetic energy in J (sections V-A and V-B)."""
        xd, rates, angles = qd[0], qd[1:], q[1:]
        energy = 0.5 * (self.m0 + sum(link.mass for link in self.links)) * xd**2
        for j, (rate, angle) in enumerate(zip(rates, angles, strict=True)):
            energy = energy + self._first_moment(j) * xd * rate * m.cos(angle)
            energy = energy + 0.5 * self._second_moment(j, j) * rate**2
            for k in range(j):
                energy = energy + self._second_moment(k, j) * rates[k] * rate * m.cos(angles[k] - angle)
        return energy

    def potential(self, q: Scalars, m: Maths) -> Any:
        """Potential energy in J (sections V-A and V-B, signed by the reading)."""
        return sum(self.up * self.g * self._first_moment(j) * m.cos(angle) for j, angle in enumerate(q[1:]))

    def shapes(self, q: Scalars, m: Maths) -> list[Shape]:
        """The cart and its links."""
        steps = [
            (link.length * m.sin(angle), self.up * link.length * m.cos(angle))
            for link, angle in zip(self.links, q[1:], strict=True)
        ]
        ends = accumulate(steps, lambda at, step: (at[0] + step[0], at[1] + step[1]), initial=(q[0], 0.0 * q[0]))
        points = [list(end) for end in ends]
        width, height = (part * self.links[0].length for part in CART)
        links = [Segment(*ends) for ends in pairwise(points)]
        return [Block(points[0], (width, height), wheels=True), *links, InputArrow(points[0], (1.0, 0.0))]

    def _first_moment(self, j: int) -> float:
        return sum(link.mass * self._arm(i, j) for i, link in enumerate(self.links))

    def _second_moment(self, j: int, k: int) -> float:
        own = self.links[j].inertia if j == k else 0.0
        return own + sum(link.mass * self._arm(i, j) * self._arm(i, k) for i, link in enumerate(self.links))

    def _arm(self, i: int, j: int) -> float:
        if j > i:
            return 0.0
        return self.links[j].centre if j == i else self.links[j].length
