"""How a time step is divided into integration sub-steps."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

LEAST = 10  # for one angle
MOST = 2000
ANGLE = 0.06  # rad a sub-step, for one angle: keeps the energy balance of every step within 1e-4 J, also at 100 rad/s
WHIP = 1.5  # with more links the outer ones snap: both bounds grow finer with this power of their number


@dataclass(frozen=True)
class Pace:
    """Sub-steps of one step of time_step s: ceil(per_rate * fastest rate among `angles`), at least `least`.

    A trajectory whose rates ask for more than `most` cannot be followed, and is given up.
    """

    time_step: float
    angles: tuple[int, ...]
    least: float
    most: float
    per_rate: float

    @classmethod
    def fixed(cls, time_step: float, substeps: int) -> "Pace":
        """Always the same number of sub-steps."""
        return cls(time_step, (), substeps, substeps, 0.0)

    @classmethod
    def tied_to(cls, time_step: float, angles: Sequence[int]) -> "Pace":
        """As many sub-steps as keep every turn within one of them below ANGLE."""
        finer = max(1, len(angles)) ** WHIP
        return cls(time_step, tuple(angles), math.ceil(LEAST * finer), MOST, finer * time_step / ANGLE)
