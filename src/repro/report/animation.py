"""Animations of stored closed loops, as GIF files."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from repro.recording.contents import DrawnShape
from repro.report import style
from repro.report.figures.figure import Canvas, new_canvas
from repro.report.figures.mechanism import at_steps, draw_goal, draw_shapes, draw_track, tip, window_of
from repro.results.results import Results
from repro.results.stored_loop import StoredLoop
from repro.tracking.files import replacing

AFTERWARDS = 1.5  # s that are shown once the goal is held
FRAME = 0.08  # s, at least
TRAIL = 1.0  # s
WIDTHS = 1.0, 1.7  # least and greatest, in parts of the height
HEIGHT = 2.6  # inches
RESOLUTION = 100


@dataclass(frozen=True)
class DrawnLoop:
    """A stored loop and its picture: the shapes along it, those of its goal, inputs (steps, n_u) as parts of limits."""

    loop: StoredLoop
    shapes: Sequence[DrawnShape]
    goal: Sequence[DrawnShape]
    inputs: np.ndarray


@dataclass(frozen=True)
class Animation:
    """One closed loop in motion; `motion` returns None where it was not run."""

    name: str
    title: str
    motion: Callable[[Results], DrawnLoop | None]


def animate_all(results: Results, animations: Sequence[Animation], folder: Path) -> list[Path]:
    """Write <name>.gif of every animation that the results can fill; return those written."""
    written = []
    for each in animations:
        motion = each.motion(results)
        if motion is not None:
            path = folder / f"{each.name}.gif"
            with replacing(path, keep_suffix=True) as temporary:
                animate(motion, temporary)
            written.append(path)
    return written


def animate(motion: DrawnLoop, path: Path) -> None:
    """Write a GIF in real time: mechanism, inputs, goal, disc, and the last second of the tip."""
    from matplotlib.animation import PillowWriter

    time = motion.loop.time
    step = float(np.median(np.diff(time)))
    stride, trail = max(1, round(FRAME / step)), round(TRAIL / step)
    last = min(len(time), motion.loop.settled + round(AFTERWARDS / step))
    path_of_tip = tip(motion.shapes)
    with style.applied():
        canvas, panel, longest = _surroundings(motion, last)
        line = panel.plot([], [], linewidth=1.0, color=style.MODEL.colour, zorder=1)[0]
        clock = panel.text(0.98, 0.02, "", transform=panel.transAxes, ha="right", fontsize=9)
        writer = PillowWriter(fps=round(1 / (stride * step)))
        with writer.saving(canvas, str(path), RESOLUTION):
            for frame in range(0, last, stride):
                line.set_data(*path_of_tip[max(0, frame - trail) : frame + 1].T)
                clock.set_text(f"{time[frame]:.1f} s")
                drawn = draw_shapes(panel, motion.shapes, frame, motion.inputs[frame], longest)
                writer.grab_frame()
                for artist in drawn:
                    artist.remove()


def _surroundings(motion: DrawnLoop, last: int) -> tuple[Canvas, Any, float]:
    """The canvas, the panel with all that stands still, and the longest arrow in m."""
    from matplotlib.patches import Circle

    obstacle = motion.loop.obstacle
    discs = [DrawnShape("disc", np.array([[obstacle[:2]]]), size=(obstacle[2], 0.0))] if obstacle else []
    window = window_of(at_steps(motion.shapes, slice(last)), motion.inputs[:last], [*motion.goal, *discs])
    width = float(np.clip(window.half[0] / window.half[1], *WIDTHS))
    half = np.array([width, 1.0]) * max(window.half[1], window.half[0] / width)
    canvas = new_canvas(width * HEIGHT, HEIGHT)
    canvas.set_layout_engine("none")
    panel = canvas.add_axes((0, 0, 1, 1))
    panel.set_xlim(window.middle[0] - half[0], window.middle[0] + half[0])
    panel.set_ylim(window.middle[1] - half[1], window.middle[1] + half[1])
    panel.axis("off")
    draw_track(panel, motion.shapes)
    draw_goal(panel, motion.goal)
    for disc in discs:
        panel.add_patch(Circle(disc.points[0, 0], disc.size[0], color="#d0605e", alpha=0.75, linewidth=0))
    return canvas, panel, window.longest
