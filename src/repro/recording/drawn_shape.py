"""One shape of a picture over time, as plain arrays."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

Kind = Literal["link", "disc", "block", "cart", "spring", "arrow", "turn"]


@dataclass(frozen=True)
class DrawnShape:
    """A shape that moves, in m, y up; from where its motion diverged its values may be anything.

    points  (steps, 2, 2), both ends of a link or a spring; (steps, 1, 2), the centre or the foot of any other
    turn    (steps,) rad, how a block is turned, or the direction of an arrow, counter-clockwise from the right
    size    half the width and height of a block; radius of a disc; radius of an arc, and 1 for clockwise or -1
    input   number of the input that an arrow or an arc shows
    """

    kind: Kind
    points: np.ndarray
    turn: np.ndarray | None = None
    size: tuple[float, float] = (0.0, 0.0)
    input: int = 0
