"""Film strips and animations of the mechanisms of the experiment swing_up: the first stored loop of each."""

from collections.abc import Mapping, Sequence
from functools import partial
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.library.drawn_motion import loop_shapes
from repro.report.animation import Animation, DrawnLoop
from repro.report.figures.figure import Figure, new_canvas
from repro.report.figures.mechanism import Window, at_steps, draw_goal, draw_shapes, tip, window_of
from repro.report.paper import load_paper
from repro.report.style import PAPER, TEXT_WIDTH
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.selectors import Where, find_loops
from repro.results.stored_loop import StoredLoop, find_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

EXPERIMENT = "swing_up"
UNDISTURBED: Where = {"mismatch": 0.0, "noise": 0.0}
MODELS = "structured", "truth"  # the first of these that was run is shown
TITLES: Mapping[str, str] = {
    "torque_pendulum": "A motor too weak to lift its pendulum swings it up.",
    "acrobot": "The acrobot, driven at its elbow alone.",
    "pendubot": "The pendubot, driven at its shoulder alone.",
    "furuta": "The rotary pendulum of Furuta, driven at its arm.",
    "dip": "Two links on a cart, without an obstacle.",
    "quadrotor": "A planar quadrotor flies to a point.",
}
FRAMES = 9
ROW, TITLE, TIMES = 0.8, 0.19, 0.16  # inches: greatest height of the frames, heading above and times below them
BETWEEN = 1.04  # widths of a frame from one to the next, at least
TRAIL = 0.4  # s of the tip's path, at most
THICKNESS = 0.55  # of the lines


def motion(results: Results, system: str) -> DrawnLoop | None:
    """The first loop of a system in the setting that reached its goal most often."""
    for model in MODELS:
        loops = find_loops(results, EXPERIMENT, {"system": system, "model": model, **UNDISTURBED})
        shares = loops.groupby("run", sort=False)["success"].mean().sort_values(ascending=False, kind="stable")
        loop = find_loop(results, EXPERIMENT, [{"run": run} for run in shares.index])
        if loop is not None:
            return DrawnLoop(loop, *loop_shapes(loop.settings, loop.series, loop.facts["x_des"]))
    return None


def draw(results: Results) -> "Canvas | None":
    """Draw one row of frames per system."""
    systems = dict.fromkeys(find_loops(results, EXPERIMENT, {})["system"])
    shown = [(each, _frames(each)) for each in (motion(results, system) for system in systems) if each is not None]
    if not shown:
        return None
    windows = [
        window_of(at_steps(each.shapes, frames), each.inputs[frames], each.goal, margin=0.03) for each, frames in shown
    ]
    heights = [min(TEXT_WIDTH * window.half[1] / (BETWEEN * FRAMES * window.half[0]), ROW) for window in windows]
    height = sum(heights) + len(shown) * (TITLE + TIMES)
    canvas, top = new_canvas(TEXT_WIDTH, height), height
    canvas.set_layout_engine("none")
    for (each, frames), window, own in zip(shown, windows, heights, strict=True):
        top -= TITLE + own + TIMES
        panel = canvas.add_axes((0, (top + TIMES) / height, 1, own / height))
        _row(panel, each, frames, window, own)
    return canvas


def _frames(shown: DrawnLoop) -> list[int]:
    """Steps at equal distances, the last of them the first at which the goal is held."""
    between = max(1, ceil(shown.loop.settled / (FRAMES - 1)))
    last = len(shown.loop.time) - 1
    return [min(number * between, last) for number in range(FRAMES)]


def _row(panel: Any, shown: DrawnLoop, frames: Sequence[int], window: Window, height: float) -> None:
    loop, (low, high) = shown.loop, window.middle[1] + window.half[1] * np.array([-1, 1])
    width = TEXT_WIDTH * (high - low) / height  # m, of the row
    left = window.middle[0] - width / FRAMES / 2
    panel.set(xlim=(left, left + width), ylim=(low, high))
    panel.axis("off")
    path = tip(shown.shapes)
    for place, step in enumerate(frames):
        shift = place * width / FRAMES
        since = max(frames[max(place - 1, 0)], int(np.searchsorted(loop.time, loop.time[step] - TRAIL)))
        panel.plot(
            path[since : step + 1, 0] + shift, path[since : step + 1, 1], linewidth=0.6, color=PAPER.colour, zorder=0.4
        )
        draw_goal(panel, shown.goal, shift=shift, thickness=THICKNESS)
        inputs = shown.inputs[step]
        draw_shapes(panel, shown.shapes, step, inputs, window.longest, shift=shift, thickness=THICKNESS)
        panel.annotate(
            f"{loop.time[step]:.2f} s", (window.middle[0] + shift, low), (0, -2), textcoords="offset points",
            ha="center", va="top", fontsize=7, annotation_clip=False,
        )  # fmt: skip
    panel.set_title(_title(loop), loc="left", x=0.01, pad=2)


def _title(loop: StoredLoop) -> str:
    facts, names = loop.facts, load_paper(Path(__file__).parents[1]).systems
    model = "true model" if facts["model"] == "truth" else f"{written('model', facts['model'])} model"
    how = f"{model}, re-identified online" if facts["adaptive"] else model
    held = facts["held_from_s"]
    outcome = "the goal is not held" if held is None else f"at its goal from {held:.2f} s on"
    return f"{names.get(facts['system'], written('model', facts['system']))}, {how}: {outcome}"


FIGURES = (
    Figure(
        "swing_up",
        "Swing-up of mechanisms by their energies",
        "Per mechanism the first of the random starts, by the model that its heading names, in the setting that "
        "reaches the goal most often, without mismatch or noise: V_cost and small weights of inputs and rates, as "
        "conf/control has them. Structured models were learned from 1,000 samples with noise in the forces. Nine "
        "frames at equal time steps, the goal dashed; a thin line is the path of the tip in the 0.4 s before, and arcs "
        "and bars are the inputs, parts of their limits.",
        "One row of frames per mechanism: hanging at first, swinging higher from frame to frame, at last at rest on the"
        " dashed outline of the goal.",
        draw,
    ),
)
ANIMATIONS = tuple(
    Animation(f"{EXPERIMENT}_{system}", title, partial(motion, system=system)) for system, title in TITLES.items()
)
