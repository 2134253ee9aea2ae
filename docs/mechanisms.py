"""Draws mechanisms as their systems describe them: all of them at rest, or the first closed loops of stored runs.

python docs/mechanisms.py          write docs/mechanisms/at_rest.png, one panel per system
python docs/mechanisms.py RUN...   write <run>.gif of stored runs with closed loops into the working folder

`repro report --publish` makes the animations of the experiment swing_up that the pages show, from its results.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import repro
from repro.library.drawn_motion import drawn_shapes, loop_shapes
from repro.mechanics.system import load
from repro.mechanics.system_options import SYSTEMS
from repro.plugins.plugin import plugin_names
from repro.report.animation import DrawnLoop, animate
from repro.report.figures.mechanism import draw_shapes, window_of
from repro.results.run_card import RunCard
from repro.results.stored_loop import stored_loop
from repro.results.table_schema import records

AT_REST = Path(__file__).parent / "mechanisms" / "at_rest.png"


def at_rest() -> Path:
    """One picture of all systems, a little away from rest, under 60 % of their inputs."""
    canvas = Figure(figsize=(8, 8), layout="constrained")
    for panel, name in zip(canvas.subplots(4, 4).ravel(), plugin_names(SYSTEMS), strict=True):
        system = load(name)
        moved = [0.3 * (-1) ** i if c.is_angle else 0.1 for i, c in enumerate(system.coordinates)]
        shapes = drawn_shapes(system, np.append(system.at_rest() + moved, np.zeros(system.n_q))[None])
        inputs = np.full((1, len(system.inputs)), 0.6)
        window = window_of(shapes, inputs)
        draw_shapes(panel, shapes, 0, inputs[0], 2 * window.longest)
        (left, low), (right, high) = window.middle - max(window.half), window.middle + max(window.half)
        panel.set(xlim=(left, right), ylim=(low, high), aspect="equal")
        panel.axis("off")
        panel.set_title(name.replace("_", " "), fontsize=9)
    canvas.savefig(AT_REST, dpi=90)
    return AT_REST


def animated(name: str) -> Path:
    """A GIF, in real time, of the first closed loop of a run."""
    run = repro.load_run(name)
    stored = run.table("closed_loops")
    first = stored[stored["loop"] == stored["loop"].min()]
    loop = stored_loop(records(run.table("control"))[0], RunCard.of(run.summary).settings, first)
    path = Path(f"{run.id}.gif")
    animate(DrawnLoop(loop, *loop_shapes(loop.settings, loop.series, loop.facts["x_des"])), path)
    return path


if __name__ == "__main__":
    for written in [animated(name) for name in sys.argv[1:]] or [at_rest()]:
        print(written)
