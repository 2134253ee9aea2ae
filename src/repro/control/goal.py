"""Where a closed loop shall end and stay, and whether it did. Success of the solver is not success of the task."""

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

    def place(self, name: str) -> float:
        """The goal's value of the coordinate of that name; nan where there is none."""
        values = {coordinate.name: float(q) for coordinate, q in zip(self.coordinates, self.q, strict=True)}
        return values.get(name, np.nan)


@dataclass(frozen=True)
class Outcome:
    """The result of a closed loop.

    success      at its goal for all of the last `hold` s, and no contact
    contact      a solid part was inside the disc at some sub-step
    clearance    the least distance of a solid part to the disc, m; nan without a disc
    held_from    time from which it stayed at the goal to the end, s; nan where it did not
    steady_error |mean of the difference to the goal| over the last `hold` s, the largest of all translations, m; nan
                 where the goal has none
    """

    success: bool
    contact: bool
    clearance: float
    held_from: float
    steady_error: float


def judge(time: np.ndarray, states: np.ndarray, clearance: np.ndarray | None, goal: Goal) -> Outcome:
    """The outcome of states (n, 2 n_q) at times (n,) in s, with their clearance (n,) in m, None without a disc.

    States that are not finite (the loop was stopped) are not at the goal.
    """
    there = goal.reached(states)
    last = time >= time[-1] - goal.hold - 1e-9
    contact = clearance is not None and bool(np.any(clearance < 0))
    away = np.flatnonzero(~there)
    first = away[-1] + 1 if away.size else 0
    places = [i for i, c in enumerate(goal.coordinates) if c.unit == "m" and np.isfinite(goal.tolerance[i])]
    return Outcome(
        success=bool(np.all(there[last])) and time[-1] >= goal.hold and not contact,
        contact=contact,
        clearance=float(np.nanmin(clearance)) if clearance is not None else np.nan,
        held_from=float(time[first]) if first < len(time) else np.nan,
        steady_error=max((float(abs(np.mean(states[last, i]) - goal.q[i])) for i in places), default=np.nan),
    )
