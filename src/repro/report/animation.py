"""Animations of stored closed loops, as GIF files for the README."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.report import style
from repro.report.paper import Animation
from repro.results.results import Results
from repro.results.stored_loop import StoredLoop, find_loop
from repro.tracking.files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

AFTERWARDS = 1.5  # s that are shown once it is erect
STRIDE = 2  # control steps per frame: 80 ms
TRAIL = 25  # control steps
SIZE = (4.2, 2.6)  # inches
RESOLUTION = 100


def animate_all(results: Results, animations: Sequence[Animation], folder: Path) -> list[Path]:
    """Write <name>.gif of every animation that the results can fill; return those written."""
    written = []
    for each in animations:
        loop = find_loop(results, each.experiment, each.choices)
        if loop is not None:
            path = folder / f"{each.name}.gif"
            with replacing(path, keep_suffix=True) as temporary:
                animate(loop, temporary)
            written.append(path)
    return written


def animate(loop: StoredLoop, path: Path) -> None:
    """Write a GIF: cart, links, the tip's last second, disc and force, in real time."""
    from matplotlib.animation import PillowWriter

    step = float(np.median(np.diff(loop.time)))
    last = min(len(loop.time), loop.settled + round(AFTERWARDS / step))
    with style.applied():
        canvas = _canvas()
        panel = canvas.add_axes((0, 0, 1, 1))
        _surroundings(panel, loop, last)
        trail = panel.plot([], [], linewidth=1.0, color=style.MODEL.colour)[0]
        force = panel.plot([], [], linewidth=2.5, color="#b0478f", solid_capstyle="butt")[0]
        links = panel.plot([], [], "-o", linewidth=3, markersize=5, color=style.PLANT.colour)[0]
        cart = panel.plot([], [], "s", markersize=13, color=style.PLANT.colour)[0]
        clock = panel.text(0.98, 0.04, "", transform=panel.transAxes, ha="right", fontsize=9)

        def draw(frame: int) -> None:
            points = loop.points[frame]
            trail.set_data(*loop.points[max(0, frame - TRAIL) : frame + 1, -1].T)
            links.set_data(*points.T)
            cart.set_data([points[0, 0]], [points[0, 1]])
            reach = np.nan_to_num(loop.series["force"][frame]) / 8
            force.set_data([points[0, 0], points[0, 0] + reach], [-0.12, -0.12])
            clock.set_text(f"{loop.time[frame]:.1f} s")

        writer = PillowWriter(fps=round(1 / (STRIDE * step)))
        with writer.saving(canvas, str(path), RESOLUTION):
            for frame in range(0, last, STRIDE):
                draw(frame)
                writer.grab_frame()


def _canvas() -> "Canvas":
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=SIZE)
    canvas.set_layout_engine("none")
    return canvas


def _surroundings(panel: Any, loop: StoredLoop, last: int) -> None:
    from matplotlib.patches import Circle

    shown = loop.points[:last]
    reach = float(np.linalg.norm(np.diff(loop.points[0], axis=0), axis=1).sum())
    top = max(reach, 0.0 if loop.obstacle is None else loop.obstacle[1] + loop.obstacle[2])
    middle = np.array([(shown[..., 0].min() + shown[..., 0].max()) / 2, (top - reach) / 2])
    half = np.array([np.ptp(shown[..., 0]) / 2, (top + reach) / 2]) + 0.08
    half = np.array(SIZE) * np.max(half / SIZE)
    panel.set_xlim(middle[0] - half[0], middle[0] + half[0])
    panel.set_ylim(middle[1] - half[1], middle[1] + half[1])
    panel.axis("off")
    panel.axhline(-0.06, linewidth=0.8, color="#8c8c8c", zorder=0)
    panel.axvline(loop.facts["x_des"], linewidth=0.8, linestyle=":", color="black", zorder=0)
    if loop.obstacle is not None:
        x, y, radius = loop.obstacle
        panel.add_patch(Circle((x, y), radius, color="#d0605e", alpha=0.75, linewidth=0))
