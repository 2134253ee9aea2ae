"""Distances of the links of a pendulum to a disc."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from repro.mechanics.system import System

Point = Sequence[Any]


@dataclass(frozen=True)
class Disc:
    """The region that no link may touch: centre (x, y up) and radius, m."""

    centre: tuple[float, float] = (0.0, 0.6)
    radius: float = 0.3

    def clearance(self, system: System, q: np.ndarray) -> np.ndarray:
        """Distance (...,) of the nearest link to the disc, m, negative inside; q: (..., n_q)."""
        points = system.body_points([q[..., i] for i in range(system.n_q)], np)
        nearest = np.min(distances_squared(points, self.centre, np), axis=0)
        return np.asarray(np.sqrt(nearest) - self.radius)


def distances_squared(points: Sequence[Point], centre: Sequence[float], m: Any) -> list[Any]:
    """Squared distance of each link (the segment between consecutive points) to a centre, m^2.

    points: [x, y] of the cart and of the end of every link; m: a maths namespace with fmin and fmax.
    """
    return [_to_segment(start, end, centre, m) for start, end in pairwise(points)]


def _to_segment(start: Point, end: Point, centre: Sequence[float], m: Any) -> Any:
    along = [end[0] - start[0], end[1] - start[1]]
    away = [centre[0] - start[0], centre[1] - start[1]]
    length = along[0] * along[0] + along[1] * along[1]
    share = m.fmin(m.fmax((along[0] * away[0] + along[1] * away[1]) / length, 0.0), 1.0)
    return (away[0] - share * along[0]) ** 2 + (away[1] - share * along[1]) ** 2
