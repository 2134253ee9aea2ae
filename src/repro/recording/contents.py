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

    points  (steps, 2, 2), both ends of a link or a spring; (steps, 1, 2), the centre or the foot of any other; more
            where several links or discs move in a row
    turn    (steps,) rad, how a block is turned, or the direction of an arrow, counter-clockwise from the right
    size    half the width and height of a block; radius of a disc; radius of an arc, and 1 for clockwise or -1
    input   number of the input that an arrow or an arc shows
    """

    kind: Kind
    points: np.ndarray
    turn: np.ndarray | None = None
    size: tuple[float, float] = (0.0, 0.0)
    input: int = 0

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
    """One trajectory on the recording's time grid; from where it diverged its values may be anything.

    state     (steps, 2 n_q), coordinates then their rates
    spread    (steps, 2 n_q), standard errors of the state, or None
    energies  name -> (steps,), J
    shapes    what the picture shows of it
    """

    state: np.ndarray
    energies: Mapping[str, np.ndarray]
    shapes: Sequence[DrawnShape]
    spread: np.ndarray | None = None


@dataclass(frozen=True)
class LearningCurve:
    """One quantity during a fit: step (n,) integers, and member -> (n,) values. The viewer has no logarithmic axis."""

    step: np.ndarray
    values: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class RunRecording:
    """All that the recording of one run shows. Raises ValueError for labels that the picture cannot tell apart.

    run          the run's id, which becomes the recording's id
    title        readable name of the run
    card         plain nested dictionary: settings, provenance, metrics
    time         (steps,), s, increasing
    coordinates  (name, unit) of each generalised coordinate
    plant        the true rollout; it, the forces and the power are finite
    models       label -> the model's rollout
    forces       coordinate -> (steps,), the generalised force along each driven one; N along metres, N m about angles
    inputs       name -> (steps,), the inputs in the order of the arrows that show them
    power        name -> (steps,), W; the first is the one that the others should add up to
    curves       name -> learning curve
    obstacle     centre x, centre y (y up) and radius, m
    predicted    (steps, nodes, 2), path of the tip that a controller predicts, m; not finite in a step without a plan
    charts       title -> unit and (steps,) values of further charts, such as what a solver did; what "title: " is
                 followed by stands in the legend, since the title of a narrow chart is cut
    """

    run: str
    title: str
    card: Mapping[str, object]
    time: np.ndarray
    coordinates: Sequence[tuple[str, str]]
    plant: DrawnMotion
    models: Mapping[str, DrawnMotion]
    forces: Mapping[str, np.ndarray]
    power: Mapping[str, np.ndarray]
    curves: Mapping[str, LearningCurve] = field(default_factory=dict)
    inputs: Mapping[str, np.ndarray] = field(default_factory=dict)
    obstacle: tuple[float, float, float] | None = None
    predicted: np.ndarray | None = None
    charts: Mapping[str, tuple[str, np.ndarray]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if len({PLANT, *map(part, self.models)}) <= len(self.models):
            raise ValueError(f"models: labels must differ from one another and from {PLANT!r}: {list(self.models)}")
