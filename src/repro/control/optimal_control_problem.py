"""The optimal control problem (9) as plain settings."""

from dataclasses import dataclass
from typing import Literal

ANGLE_ERRORS = ("cosine", "square")


@dataclass(frozen=True)
class Weights:
    """What one node of the horizon costs.

    kinetic T + potential V_cost + position (x - x_des)^2 + angle sum_j e(theta_j) + rates |qd|^2 + force f^2, where
    V_cost = -V in the physical reading and e is the angle error of the problem.
    """

    kinetic: float = 0.0
    potential: float = 0.0
    position: float = 0.0
    angle: float = 0.0
    rates: float = 0.0
    force: float = 0.0


@dataclass(frozen=True)
class Obstacle:
    """A disc that no link may touch: centre (x, y up) and radius in m; the controller keeps `margin` radii away.

    Soft: weight * sum over links of max(0, (margin r)^2 - d^2)^2 at every node but the first, and with `midpoints` in
    the middle of every interval. Hard: d^2 >= (margin r)^2 at the same places.
    """

    centre: tuple[float, float] = (0.0, 0.6)
    radius: float = 0.3
    margin: float = 1.05
    hard: bool = False
    weight: float = 1e6
    midpoints: bool = False

    @property
    def least_squared(self) -> float:
        """The squared distance to keep, m^2."""
        return (self.margin * self.radius) ** 2


@dataclass(frozen=True)
class Problem:
    """Problem (9) over a horizon of intervals, s each, not all alike; the first is the sampling time.

    The running cost of node k counts for its interval: its weight is its length over the first one's.
    """

    intervals: tuple[float, ...]
    running: Weights
    terminal: Weights
    obstacle: Obstacle | None = None
    force_limit: float = 4.0
    speed_limit: float | None = None
    angle_error: Literal["cosine", "square"] = "cosine"

    @property
    def time_step(self) -> float:
        """Sampling time of the controller, s."""
        return self.intervals[0]

    @property
    def horizon(self) -> float:
        """Length of the horizon, s."""
        return sum(self.intervals)
