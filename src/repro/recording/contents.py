"""What a recording shows, as plain arrays."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

FILENAME = "recording.rrd"
PLANT = "plant"
Kind = Literal["link", "disc", "block", "cart", "spring", "arrow", "turn"]


def part(label: str) -> str:
    """A label as one part of an entity's path."""
    return re.sub(r"[^\w.+-]+", "_", label)


@dataclass(frozen=True)
class DrawnShape:
    """A shape that moves, in m, y up; from where its motion diverged its values may be anything.

    points: (steps, 2, 2), both ends of a link or a spring; (steps, 1, 2), the centre or the foot of any other; more
    where several links or discs move in a row. size: half the width and height of a block; radius of a disc; coils of a
    spring; radius of an arc, and 1 for clockwise or -1.
    """

    kind: Kind
    points: np.ndarray
    turn: np.ndarray | None = None  # (steps,) rad of a block or an arrow, counter-clockwise from the right
    size: tuple[float, float] = (0.0, 0.0)
    input: int = 0  # number of the input that an arrow or an arc shows

    def coils(self, width: float) -> np.ndarray:
        """A zigzag (steps, corners, 2) between the ends of a spring, `width` m to either side."""
        start, along = self.points[:, :1], self.points[:, 1:] - self.points[:, :1]
        corners = 2 * int(self.size[0]) + 2
        side = np.zeros(corners)
        side[1:-1] = width * (-1.0) ** np.arange(corners - 2)
        with np.errstate(invalid="ignore", divide="ignore"):
            across = np.nan_to_num(along[..., ::-1] * [-1.0, 1.0] / np.linalg.norm(along, axis=-1, keepdims=True))
        zigzag: np.ndarray = start + along * np.linspace(0, 1, corners)[:, None] + across * side[:, None]
        return zigzag


@dataclass(frozen=True)
class DrawnMotion:
    """One trajectory on the recording's time grid; from where it diverged its values may be anything."""

    state: np.ndarray  # (steps, 2 n_q), coordinates then their rates
    energies: Mapping[str, np.ndarray]  # name -> (steps,), J
    shapes: Sequence[DrawnShape]  # what the picture shows of it
    spread: np.ndarray | None = None  # (steps, 2 n_q), standard errors of the state, or None


@dataclass(frozen=True)
class LearningCurve:
    """One quantity during a fit: step (n,) integers, and member -> (n,) values. The viewer has no logarithmic axis."""

    step: np.ndarray
    values: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class RunRecording:
    """All that the recording of one run shows. Raises ValueError for labels that the picture cannot tell apart.

    charts: title -> unit and (steps,) values of further charts, such as what a solver did; what "title: " is followed
    by stands in the legend, since the title of a narrow chart is cut.
    """

    run: str  # the run's id, which becomes the recording's id
    title: str  # readable name of the run
    card: Mapping[str, object]  # plain nested dictionary: settings, provenance, metrics
    time: np.ndarray  # (steps,), s, increasing
    coordinates: Sequence[tuple[str, str]]  # (name, unit) of each generalised coordinate
    plant: DrawnMotion  # the true rollout; it, the forces and the power are finite
    models: Mapping[str, DrawnMotion]  # label -> the model's rollout
    forces: Mapping[str, np.ndarray]  # driven coordinate -> (steps,); N along metres, N m about angles
    power: Mapping[str, np.ndarray]  # name -> (steps,), W; the first is the one that the others should add up to
    curves: Mapping[str, LearningCurve] = field(default_factory=dict)  # name -> learning curve
    inputs: Mapping[str, np.ndarray] = field(default_factory=dict)  # name -> (steps,), in the order of their arrows
    obstacle: tuple[float, float, float] | None = None  # centre x, centre y (y up) and radius, m
    predicted: np.ndarray | None = None  # (steps, nodes, 2), the planned path of the tip, m; not finite without a plan
    charts: Mapping[str, tuple[str, np.ndarray]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if len({PLANT, *map(part, self.models)}) <= len(self.models):
            raise ValueError(f"models: labels must differ from one another and from {PLANT!r}: {list(self.models)}")
