"""Distances of the solid parts of a system to a disc."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, assert_never

import numpy as np

from repro.mechanics.shapes import Block, Circle, InputArrow, Point, Segment, Shape, Spring, Turn
from repro.mechanics.system import System


@dataclass(frozen=True)
class Disc:
    """The region that no solid part may touch: centre (x, y up) and radius, m."""

    centre: tuple[float, float] = (0.0, 0.6)
    radius: float = 0.3

    def clearance(self, system: System, q: np.ndarray) -> np.ndarray:
        """Distance (...,) of the nearest solid part to the disc, m, negative inside; q: (..., n_q)."""
        shapes = system.shapes([q[..., i] for i in range(system.n_q)], np)
        nearest = np.min(np.broadcast_arrays(*distances_squared(shapes, self.centre, np)), axis=0)
        return np.asarray(np.sqrt(nearest) - self.radius)


def distances_squared(shapes: Sequence[Shape], centre: Sequence[float], m: Any) -> list[Any]:
    """Squared distance of each solid shape to a centre, m^2; m: a maths namespace with fmin and fmax."""
    found = []
    for shape in shapes:
        match shape:
            case Segment(solid=True):
                found.append(_to_segment(shape.a, shape.b, centre, m))
            case Circle(solid=True):
                across, up = shape.centre[0] - centre[0], shape.centre[1] - centre[1]
                found.append(m.fmax(m.sqrt(across**2 + up**2) - shape.radius, 0.0) ** 2)
            case Block(solid=True):
                across, up = centre[0] - shape.centre[0], centre[1] - shape.centre[1]
                cosine, sine = m.cos(shape.angle), m.sin(shape.angle)
                own = cosine * across + sine * up, cosine * up - sine * across
                found.append(sum(m.fmax(m.fabs(at) - half, 0.0) ** 2 for at, half in zip(own, shape.half, strict=True)))
            case Segment() | Circle() | Block() | Spring() | InputArrow() | Turn():
                pass
            case other:
                assert_never(other)
    return found


def _to_segment(start: Point, end: Point, centre: Sequence[float], m: Any) -> Any:
    along = [end[0] - start[0], end[1] - start[1]]
    away = [centre[0] - start[0], centre[1] - start[1]]
    length = along[0] * along[0] + along[1] * along[1]
    share = m.fmin(m.fmax((along[0] * away[0] + along[1] * away[1]) / length, 0.0), 1.0)
    return (away[0] - share * along[0]) ** 2 + (away[1] - share * along[1]) ** 2
