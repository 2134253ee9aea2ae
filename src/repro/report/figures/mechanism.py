"""A mechanism in a panel: its shapes at one moment, filled, or as the outline of where it shall be."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, assert_never

import numpy as np

from repro.recording.contents import DrawnShape
from repro.report import style

BODY, INPUT, GOAL = style.PLANT.colour, "#b0478f", "#6b6b6b"
WIDEST = 140.0  # degrees, the arc of a torque at its limit
LONGEST = 0.2  # of the extent of a mechanism's motion, the arrow of a force at its limit
SPRING = 0.05  # m, half the width of a coil
WHEEL = 0.4  # of half the height of a cart


@dataclass(frozen=True)
class Window:
    """The box that holds what is drawn, m: its middle [x, y], half its width and height, and the longest arrow."""

    middle: np.ndarray
    half: np.ndarray
    longest: float


def window_of(
    shapes: Sequence[DrawnShape], inputs: np.ndarray, goal: Sequence[DrawnShape] = (), margin: float = 0.06
) -> Window:
    """The window of shapes and a goal; inputs: (steps, n_u), parts of their limits; margin: a part of its extent."""
    bodies = [*shapes, *goal]
    low = np.min([shape.points.min(axis=(0, 1)) - _reach(shape) for shape in bodies], axis=0)
    high = np.max([shape.points.max(axis=(0, 1)) + _reach(shape) for shape in bodies], axis=0)
    longest = LONGEST * np.max(high - low)
    for shape in shapes:
        if shape.kind == "arrow" and shape.turn is not None:
            heads = shape.points[:, 0] + longest * _along(shape.turn) * inputs[:, [shape.input]]
            low, high = np.minimum(low, heads.min(axis=0)), np.maximum(high, heads.max(axis=0))
    return Window((low + high) / 2, (high - low) / 2 + margin * np.max(high - low), longest)


def _along(angle: np.ndarray) -> np.ndarray:
    """Directions (..., 2) of angles in rad."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _reach(shape: DrawnShape) -> float:
    """How far a shape goes beyond its points."""
    match shape.kind:
        case "link" | "spring" | "arrow":
            return 0.0
        case "disc" | "turn":
            return shape.size[0]
        case "block":
            return float(np.hypot(*shape.size))
        case "cart":
            return max(shape.size[0], (1 + 2 * WHEEL) * shape.size[1])
        case other:
            assert_never(other)


def at_steps(shapes: Sequence[DrawnShape], steps: Sequence[int] | slice) -> list[DrawnShape]:
    """The shapes at some of their steps."""
    return [
        replace(shape, points=shape.points[steps], turn=None if shape.turn is None else shape.turn[steps])
        for shape in shapes
    ]


def tip(shapes: Sequence[DrawnShape]) -> np.ndarray:
    """Places (steps, 2) of the end of the last link; of the last shape where there is none."""
    links = [shape for shape in shapes if shape.kind == "link"] or shapes
    return np.asarray(links[-1].points[:, -1])


def draw_shapes(
    panel: Any,
    shapes: Sequence[DrawnShape],
    step: int,
    inputs: np.ndarray,
    longest: float,
    *,
    shift: float = 0.0,
    thickness: float = 1.0,
) -> list[Any]:
    """Draw a mechanism at one step, `shift` m further right; returns what was added to the panel.

    inputs: (n_u,), parts of their limits; longest: m, the arrow of a limit; thickness: of lines, 1 for the usual ones.
    """
    drawn: list[Any] = []
    for shape in shapes:
        if shape.kind in ("arrow", "turn"):
            share = float(inputs[shape.input])
            drawn += _input(panel, shape, step, share, longest, shift, thickness)
        else:
            looks = {"color": BODY, "linewidth": 2.6 * thickness, "solid_capstyle": "round"}
            drawn += _body(panel, shape, step, shift, looks, {"color": BODY, "linewidth": 0})
    return drawn


def draw_goal(panel: Any, shapes: Sequence[DrawnShape], *, shift: float = 0.0, thickness: float = 1.0) -> None:
    """Draw the outline of a mechanism at its goal, `shapes` having one step, `shift` m further right."""
    dashed = {"linewidth": 0.9 * thickness, "linestyle": (0, (2.5, 1.5)), "zorder": 0.5}
    for shape in shapes:
        if shape.kind not in ("arrow", "turn"):
            edge = {"fill": False, "edgecolor": GOAL, **dashed}
            _body(panel, shape, 0, shift, {"color": GOAL, **dashed}, edge)


def _body(panel: Any, shape: DrawnShape, step: int, shift: float, line: Any, face: Any) -> list[Any]:
    from matplotlib.patches import Circle, Rectangle

    points = shape.points[step] + [shift, 0.0]
    match shape.kind:
        case "link":
            return list(panel.plot(*points.T, **line))
        case "spring":
            zigzag = replace(shape, points=points[None]).coils(-SPRING)[0]
            return list(panel.plot(*zigzag.T, **(line | {"linewidth": 0.8})))
        case "disc":
            return [panel.add_patch(Circle(points[0], shape.size[0], **face))]
        case _:
            half = np.array(shape.size)
            turn = 0.0 if shape.turn is None else float(shape.turn[step])
            box = Rectangle(points[0] - half, *(2 * half), angle=np.degrees(turn), rotation_point="center", **face)
            drawn = [panel.add_patch(box)]
            if shape.kind == "cart":
                along, up = _along(np.array(turn)), _along(np.array(turn + np.pi / 2))
                radius = WHEEL * half[1]
                axles = [points[0] + side * half[0] * along - (half[1] + radius) * up for side in (-0.6, 0.6)]
                drawn += [panel.add_patch(Circle(axle, radius, **face)) for axle in axles]
            return drawn


def _input(
    panel: Any, shape: DrawnShape, step: int, share: float, longest: float, shift: float, thickness: float
) -> list[Any]:
    from matplotlib.patches import Arc

    foot = shape.points[step, 0] + [shift, 0.0]
    if shape.turn is not None:
        ends = np.stack([foot, foot + longest * share * _along(shape.turn[step])])
        return list(panel.plot(*ends.T, color=INPUT, linewidth=1.8 * thickness, solid_capstyle="butt", zorder=3))
    first, last = sorted((90.0, 90.0 - WIDEST * share * shape.size[1]))
    width = 2 * shape.size[0]
    arc = Arc(foot, width, width, theta1=first, theta2=last, color=INPUT, linewidth=1.8 * thickness, zorder=3)
    return [panel.add_patch(arc)]


def draw_track(panel: Any, shapes: Sequence[DrawnShape]) -> None:
    """Draw what carts roll on."""
    for shape in shapes:
        if shape.kind == "cart":
            turn = 0.0 if shape.turn is None else float(shape.turn[0])
            down = (1 + 2 * WHEEL) * shape.size[1] * _along(np.array(turn - np.pi / 2))
            panel.axline(shape.points[0, 0] + down, slope=np.tan(turn), color="#8c8c8c", linewidth=0.8, zorder=0)
