"""A generalised coordinate and an input: name, unit, and the properties that a model uses besides the samples."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Scalars = Sequence[Any]  # one number, array or expression per coordinate
Maths = Any  # a namespace with cos and sin for these: numpy, torch, casadi
Rows = Sequence[Scalars]  # of a matrix
FORCES = {"m": "N", "rad": "N m", "C": "V"}  # unit of a coordinate -> unit of the force that does work along it


@dataclass(frozen=True)
class Coordinate:
    """One generalised coordinate: its name and its unit."""

    name: str
    unit: str
    is_angle: bool  # it is the same after a whole turn
    cyclic: bool = False  # neither T nor V depends on it
    absolute: bool = (
        False  # from the vertical, though its joint is on the link before: friction acts on the two rates' gap
    )

    @property
    def force_unit(self) -> str:
        """Unit of the generalised force along it."""
        return FORCES.get(self.unit, f"J/{self.unit}")

    @property
    def rate_unit(self) -> str:
        """Unit of its rate."""
        return "A" if self.unit == "C" else f"{self.unit}/s"


@dataclass(frozen=True)
class Input:
    """One input: its name, its unit, and the limit of its size."""

    name: str
    unit: str
    limit: float


def joint_rates(n_q: int, jointed: Sequence[int]) -> np.ndarray:
    """Matrix (n_q, n_q) of the joints' rates: those of `jointed` coordinates, absolute angles, less the one before."""
    matrix = np.eye(n_q)
    matrix[list(jointed), [i - 1 for i in jointed]] = -1.0
    return matrix


def jointed(coordinates: Sequence[Coordinate]) -> tuple[int, ...]:
    """Positions of the absolute angles."""
    return tuple(i for i, coordinate in enumerate(coordinates) if coordinate.absolute)
