"""The counterparts of the paper's Figs. 5 and 6: one closed loop as a picture of its motion and as curves."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from repro.library.drawn_motion import loop_shapes
from repro.report import style
from repro.report.animation import Animation, DrawnLoop
from repro.report.figures.figure import Figure, new_canvas
from repro.report.style import TEXT_WIDTH
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.selectors import Where
from repro.results.stored_loop import StoredLoop, find_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

POSES = 26
MARGIN = 1.05  # radii that the controllers keep
# The first of these that was run is shown.
SINGLE: Sequence[Where] = (
    {"setting": "sip", "basis": "t2", "optimiser": "levenberg_marquardt", "energies": "canonical"},
    {"setting": "sip", "model": "structured"},
    {"setting": "sip", "model": "truth", "intervals": 20},
)
DOUBLE: Sequence[Where] = (
    {"setting": "dip_best", "model": "structured", "task": "random"},
    {"setting": "dip_best", "basis": "fxf", "task": "random"},
    {"setting": "dip_best", "model": "truth", "task": "random"},
)


def motion(results: Results, experiment: str, choices: Sequence[Where]) -> DrawnLoop | None:
    """The stored loop of the first choice that was run."""
    loop = find_loop(results, experiment, choices)
    return None if loop is None else DrawnLoop(loop, *loop_shapes(loop.settings, loop.series, loop.facts["x_des"]))


def draw(results: Results, experiment: str, choices: Sequence[Where]) -> "Canvas | None":
    """Draw the loop that the animation shows too."""
    shown = motion(results, experiment, choices)
    if shown is None:
        return None
    loop = shown.loop
    canvas = new_canvas(TEXT_WIDTH, 5.6)
    halves: Any = canvas.subfigures(1, 2, width_ratios=[1.05, 1.0])
    left, right = halves
    scene, clearance = left.subplots(2, 1, height_ratios=[2.2, 1.0])
    _poses(left, scene, shown)
    _clearance(clearance, loop)
    energies, position, angles, force = right.subplots(4, 1, sharex=True)
    _energies(energies, loop)
    _position(position, loop)
    _angles(angles, loop)
    force.step(loop.time, loop.series["force"], where="post", color=style.PLANT.colour, linewidth=0.9)
    for limit in (-4, 4):
        force.axhline(limit, linewidth=0.8, **style.ANCHOR.line_style)
    force.set_ylabel("force [N]")
    force.set_xlabel("time [s]")
    for panel in (clearance, energies, position, angles, force):
        if loop.facts["held_from_s"] is not None:
            panel.axvline(loop.facts["held_from_s"], linewidth=0.8, color=style.PAPER.colour)
    return canvas


def _poses(figure: Any, panel: Any, shown: DrawnLoop) -> None:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    loop, links = shown.loop, [shape.points for shape in shown.shapes if shape.kind == "link"]
    points = np.stack([links[0][:, 0], *(link[:, 1] for link in links)], axis=1)
    colours, last = colormaps["viridis"], max(loop.settled, 1)
    panel.plot(*points[: last + 1, -1].T, linewidth=0.5, color=style.PAPER.colour)
    for step in np.unique(np.linspace(0, last, POSES).round().astype(int)):
        first_or_last = step in (0, last)
        colour = "black" if first_or_last else colours(step / last)
        panel.plot(*points[step].T, color=colour, linewidth=1.6 if first_or_last else 0.9, zorder=2 + first_or_last)
        panel.plot(*points[step, 0], "s", color=colour, markersize=3)
    if loop.obstacle is not None:
        _disc(panel, loop.obstacle)
    panel.axvline(loop.facts["x_des"], linewidth=0.9, linestyle=":", color="black")
    panel.set_aspect("equal")
    panel.set_xlabel("x [m]")
    panel.set_ylabel("y [m]")
    model = written("basis", loop.facts["basis"]) if loop.facts["basis"] else loop.facts["model"]
    panel.set_title(f"{model}, {written('setting', loop.facts['setting'])}, x_des = {loop.facts['x_des']:g} m")
    scale = ScalarMappable(Normalize(0, loop.time[last]), colours)
    figure.colorbar(scale, ax=panel, location="top", fraction=0.05, pad=0.02, label="time [s]")


def _disc(panel: Any, obstacle: tuple[float, float, float]) -> None:
    from matplotlib.patches import Circle

    x, y, radius = obstacle
    panel.add_patch(Circle((x, y), radius, color="#d0605e", alpha=0.75, linewidth=0))
    panel.add_patch(Circle((x, y), MARGIN * radius, fill=False, linestyle="--", linewidth=0.8, color="#7a2f2e"))


def _clearance(panel: Any, loop: StoredLoop) -> None:
    if "clearance" in loop.series and loop.obstacle is not None:
        panel.plot(loop.time, loop.series["clearance"], **style.PLANT.line_style)
        panel.axhline((MARGIN - 1) * loop.obstacle[2], linewidth=0.8, linestyle="--", color="#7a2f2e")
    panel.axhline(0, linewidth=0.9, color="#d0605e")
    panel.set_ylabel("clearance [m]")
    panel.set_xlabel("time [s]")


def _energies(panel: Any, loop: StoredLoop) -> None:
    for name, role in zip("TVH", style.SERIES, strict=False):
        panel.plot(loop.time, loop.series[name], label=name, **role.line_style)
    if loop.facts["held_from_s"] is not None:
        panel.axhline(loop.series["V"][loop.settled :].mean(), linewidth=0.8, **style.ANCHOR.line_style)
    panel.set_ylabel("energy [J]")
    panel.legend(ncols=3, loc="lower right")


def _position(panel: Any, loop: StoredLoop) -> None:
    x_des = loop.facts["x_des"]
    panel.axhspan(x_des - 0.05, x_des + 0.05, color="#e3e3e3", linewidth=0)
    panel.plot(loop.time, loop.series["x"], **style.PLANT.line_style)
    panel.set_ylabel("x [m]")


def _angles(panel: Any, loop: StoredLoop) -> None:
    panel.axhspan(-5, 5, color="#e3e3e3", linewidth=0)
    for name, role in zip(loop.angles, style.SERIES, strict=False):
        turned = (np.degrees(loop.series[name]) + 180) % 360 - 180
        turned[1:][np.abs(np.diff(turned)) > 180] = np.nan
        panel.plot(loop.time, turned, label=name.replace("theta", "θ"), **role.line_style)
    panel.set_ylabel("angle [deg], 0 up")
    if len(loop.angles) > 1:
        panel.legend(ncols=2, loc="lower right")


FIGURES = (
    Figure(
        "sip_closed_loop",
        "Swing-up of the single pendulum past the obstacle, as in Fig. 5",
        "Left: poses from start (black) to erect (black), the tip's path, the disc with its 5 % margin, x_des dotted;"
        " below, the clearance of the link. Right: energies of the plant, position with the 5 cm band, angle with the"
        " 5 degree band, force. The vertical line: erect from there on. Above the picture: model and setting, ours and"
        " not the printed ones.",
        "Cart and one link drawn at many moments from hanging to erect past a disc; beside them clearance, energies, "
        "position, angle and force over time.",
        partial(draw, experiment="sip_control", choices=SINGLE),
    ),
    Figure(
        "dip_closed_loop",
        "Swing-up of the double pendulum past the obstacle, as in Fig. 6",
        "As the figure before, with two rods and the smaller disc.",
        "Cart and two links drawn at many moments from hanging to erect past a small disc; beside them clearance, "
        "energies, position, angles and force over time.",
        partial(draw, experiment="dip_control", choices=DOUBLE),
    ),
)
ANIMATIONS = (
    Animation(
        "sip_swing_up",
        "One link swings up past the disc and is held there.",
        partial(motion, experiment="sip_control", choices=SINGLE),
    ),
    Animation(
        "dip_swing_up",
        "Two links swing up past the disc and are held there.",
        partial(motion, experiment="dip_control", choices=DOUBLE),
    ),
)
