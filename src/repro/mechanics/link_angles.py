"""Systems of links whose absolute angles follow a reading of the paper's conventions."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, assert_never

import numpy as np

from repro.errors import UserError
from repro.mechanics.system import System
from repro.mechanics.system_options import Reading

READINGS = tuple(Reading)
DAMPING_FRAMES = ("relative", "absolute")


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

    def __post_init__(self) -> None:
        for what, allowed in (("reading", READINGS), ("damping_frame", DAMPING_FRAMES)):
            if getattr(self, what) not in allowed:
                raise UserError(f"unknown {what} {getattr(self, what)!r}: choose one of {', '.join(allowed)}")
        if not math.isfinite(self.damping_growth) or self.damping_growth < 0:
            raise UserError(f"damping_growth = {self.damping_growth} of {self.name}: must not be negative")
        super().__post_init__()

    @property
    def up(self) -> float:
        """Cosine of the upright angle: 1 where angles are measured from upright, -1 where from hanging."""
        match self.reading:
            case Reading.PHYSICAL:
                return 1.0
            case Reading.PRINTED:
                return -1.0
            case _:
                assert_never(self.reading)

    @property
    def upright(self) -> np.ndarray:
        """Coordinates (n_q,) with every link pointing up and all else at 0."""
        return self.at_rest("upright")

    @property
    def hanging(self) -> np.ndarray:
        """Coordinates (n_q,) with every link pointing down and all else at 0."""
        return self.at_rest("hanging")

    @property
    def rest_states(self) -> Mapping[str, tuple[float, ...]]:
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

    def growth(self, i: int, q: Sequence[Any], m: Any) -> Any:
        """Factor of the viscous coefficient of coordinate i at q."""
        return 1 + self.damping_growth * m.sin(q[i]) ** 2 if self.damping_growth and i in self.angles else 1.0
