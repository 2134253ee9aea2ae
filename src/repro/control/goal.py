"""Where a closed loop shall end and stay."""

from dataclasses import dataclass

import numpy as np

from repro.mechanics.coordinate import Coordinate


@dataclass(frozen=True)
class Goal:
    """A state of rest q (n_q,) to hold for `hold` s, each coordinate within its tolerance, infinite where it is free.

    Angles count modulo a turn.
    """

    coordinates: tuple[Coordinate, ...]
    q: np.ndarray
    tolerance: np.ndarray
    hold: float

    def error(self, q: np.ndarray) -> np.ndarray:
        """Difference (..., n_q) of coordinates (..., n_q) to the goal, that of an angle the shortest way round."""
        errors = q - self.q
        turns = np.array([coordinate.is_angle for coordinate in self.coordinates])
        return np.asarray(np.where(turns, (errors + np.pi) % (2 * np.pi) - np.pi, errors))

    def reached(self, states: np.ndarray) -> np.ndarray:
        """Whether states (..., 2 n_q) are within the tolerances, (...,); those that are not finite are not."""
        judged = np.isfinite(self.tolerance)
        with np.errstate(invalid="ignore"):
            within = np.abs(self.error(states[..., : len(self.q)])) < self.tolerance
        return np.asarray(np.all(within[..., judged], axis=-1) & np.all(np.isfinite(states), axis=-1))

    @property
    def judged_translations(self) -> list[int]:
        """Positions of the coordinates in m that the goal fixes."""
        return [i for i, c in enumerate(self.coordinates) if c.unit == "m" and np.isfinite(self.tolerance[i])]

    def place(self, name: str) -> float:
        """The goal's value of the coordinate of that name; nan where there is none."""
        values = {coordinate.name: float(q) for coordinate, q in zip(self.coordinates, self.q, strict=True)}
        return values.get(name, np.nan)
