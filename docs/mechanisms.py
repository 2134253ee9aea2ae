"""Draws mechanisms as their systems describe them: all of them at rest, or the first closed loops of stored runs.

python docs/mechanisms.py          write docs/mechanisms/at_rest.png, one panel per system
python docs/mechanisms.py RUN...   write docs/mechanisms/<system>.gif from stored runs, such as those of swing_up
"""

import math
import sys
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Any, assert_never

import numpy as np
import pandas as pd
from matplotlib import patches
from matplotlib.animation import PillowWriter
from matplotlib.figure import Figure

import repro
from repro.mechanics.shapes import Block, Circle, InputArrow, Segment, Shape, Spring, Turn
from repro.mechanics.system import System, load, names
from repro.pipeline.stages.close_loops import FIRST, LOOPS
from repro.tracking.load import Run

FOLDER = Path(__file__).parent / "mechanisms"
BODY, INPUT = "#1f4e79", "#b0478f"
STRIDE = 2  # control steps per frame
AFTERWARDS = 1.0  # s that are shown once the goal is held


def drawn(panel: Any, shapes: Sequence[Shape], inputs: Sequence[float], size: float) -> None:
    """Shapes in a panel, the inputs as parts of their limits; size: of the longest arrow, m."""
    for shape in shapes:
        match shape:
            case Segment():
                panel.plot(*zip(shape.a, shape.b, strict=True), color=BODY, linewidth=3 if shape.solid else 1)
            case Circle():
                panel.add_patch(patches.Circle(shape.centre, shape.radius, color=BODY))
            case Block():
                _block(panel, shape)
            case Spring():
                _spring(panel, shape)
            case InputArrow():
                reach = np.multiply(shape.along, size * inputs[shape.input])
                panel.plot(*zip(shape.at, np.add(shape.at, reach), strict=True), color=INPUT, linewidth=2.5)
            case Turn():
                angle = -90.0 * inputs[shape.input] * (1 if shape.clockwise else -1)
                first, last = sorted((90.0, 90.0 + angle))
                around = 2 * shape.radius
                arc = patches.Arc(shape.at, around, around, theta1=first, theta2=last, color=INPUT, linewidth=2.5)
                panel.add_patch(arc)
            case other:
                assert_never(other)


def _block(panel: Any, shape: Block) -> None:
    (x, y), (width, height) = shape.centre, shape.half
    corner = (x - width, y - height)
    box = patches.Rectangle(corner, 2 * width, 2 * height, color=BODY, alpha=0.7, rotation_point="center")
    box.set_angle(math.degrees(shape.angle))
    panel.add_patch(box)


def _spring(panel: Any, shape: Spring) -> None:
    a, along = np.array(shape.a, dtype=float), np.subtract(shape.b, shape.a)
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along) * (0.05 if shape.coils else 0.0)
    shares = np.linspace(0, 1, 2 * shape.coils + 2)
    sides = np.resize([1.0, -1.0], len(shares)) * (np.minimum(shares, 1 - shares) > 0)
    panel.plot(*(a + shares[:, None] * along + sides[:, None] * across).T, color=BODY, linewidth=1)


def shapes_at(system: System, q: np.ndarray) -> Sequence[Shape]:
    """The shapes at q (n_q,)."""
    return system.shapes(list(q), np)


def frame(panel: Any, shapes: Sequence[Shape]) -> float:
    """Set limits that hold all shapes, with equal axes; returns their extent in m."""
    points = np.array([point for shape in shapes for point in _ends(shape)], dtype=float)
    middle, half = (points.max(0) + points.min(0)) / 2, max(0.5 * np.ptp(points, axis=0).max(), 0.1) * 1.15
    panel.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")
    panel.axis("off")
    return 2 * half


def _ends(shape: Shape) -> Sequence[Any]:
    match shape:
        case Segment() | Spring():
            return [shape.a, shape.b]
        case Circle():
            return [np.add(shape.centre, side * shape.radius) for side in (-1, 1)]
        case Turn():
            return [np.add(shape.at, side * shape.radius) for side in (-1, 1)]
        case Block():
            return [np.add(shape.centre, side * np.hypot(*shape.half)) for side in (-1, 1)]
        case InputArrow():
            return [shape.at]
        case other:
            assert_never(other)


def at_rest() -> Path:
    """One picture of all systems, a little away from rest, under 60 % of their inputs."""
    canvas = Figure(figsize=(8, 8), layout="constrained")
    for panel, name in zip(canvas.subplots(4, 4).ravel(), names(), strict=True):
        system = load(name)
        moved = [0.3 * (-1) ** i if c.is_angle else 0.1 for i, c in enumerate(system.coordinates)]
        shapes = shapes_at(system, system.at_rest() + moved)
        drawn(panel, shapes, [0.6] * len(system.inputs), 0.3 * frame(panel, shapes))
        panel.set_title(name.replace("_", " "), fontsize=9)
    path = FOLDER / "at_rest.png"
    canvas.savefig(path, dpi=90)
    return path


def animated(run: Run) -> Path:
    """A GIF, in real time, of the first closed loop of a run."""
    system, loops = load(run.card["system"]), run.upstream["control"].record
    with np.load(loops.path(FIRST)) as stored:
        states, inputs, time = (stored[name] for name in ("states", "inputs", "time"))
    between = STRIDE * ((len(time) - 1) // len(inputs))
    held = pd.read_parquet(loops.path(LOOPS)).held_from_s[0]
    last = np.searchsorted(time, held + AFTERWARDS) if np.isfinite(held) else len(time)
    shown, limits = states[:last:between, : system.n_q], np.abs(inputs).max(axis=0)
    whole = list(chain.from_iterable(shapes_at(system, q) for q in shown))
    canvas = Figure(figsize=(2.6, 2.6))
    panel = canvas.add_axes((0, 0, 1, 1))
    path = FOLDER / f"{system.name}.gif"
    writer = PillowWriter(fps=round(1 / time[between]))
    with writer.saving(canvas, str(path), 100):
        for number, q in enumerate(shown):
            panel.clear()
            size = 0.25 * frame(panel, whole)
            drawn(panel, shapes_at(system, q), inputs[number * STRIDE] / limits, size)
            clock = f"{number * time[between]:.1f} s"
            panel.text(0.97, 0.03, clock, ha="right", transform=panel.transAxes, fontsize=8)
            writer.grab_frame()
    return path


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    runs = [repro.load_run(name) for name in sys.argv[1:]]
    for written in [animated(run) for run in runs] or [at_rest()]:
        print(written)
