"""Drawing primitives: what a system consists of, in world coordinates [x, y] in m, y up.

Coordinates are numbers, arrays or expressions, as the coordinates of the system are that they are made from. An
obstacle is kept away from what is `solid`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

Point = Sequence[Any]


@dataclass(frozen=True)
class Segment:
    """A link or a wall from a to b."""

    a: Point
    b: Point
    solid: bool = True


@dataclass(frozen=True)
class Circle:
    """A wheel, a ball or a pivot."""

    centre: Point
    radius: float
    solid: bool = False


@dataclass(frozen=True)
class Block:
    """A block of half its width and height, turned by `angle` in rad; on wheels it is a cart on its track."""

    centre: Point
    half: tuple[float, float]
    angle: Any = 0.0
    wheels: bool = False
    solid: bool = False


@dataclass(frozen=True)
class Spring:
    """A spring or a rope from a to b."""

    a: Point
    b: Point
    coils: int = 8


@dataclass(frozen=True)
class InputArrow:
    """Input number `input` as an arrow from `at` along the direction `along`, a vector of length 1."""

    at: Point
    along: Point
    input: int = 0


@dataclass(frozen=True)
class Turn:
    """Input number `input` as an arc about `at`, from its top; a positive one turns `clockwise` or not."""

    at: Point
    radius: float
    input: int = 0
    clockwise: bool = True


Shape = Segment | Circle | Block | Spring | InputArrow | Turn
