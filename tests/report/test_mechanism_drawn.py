"""Mechanisms as figures draw them: in their window, at their goal, in frames at equal time steps."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from synthetic_loops import loop, results

from repro.library.drawn_motion import drawn_shapes, loop_shapes
from repro.mechanics.system import load
from repro.mechanics.system_options import SYSTEMS
from repro.plugins.plugin import plugin_names
from repro.report.figures.mechanism import at_steps, draw_goal, draw_shapes, draw_track, tip, window_of
from repro.report.paper import load_animations, load_figures, paper_folder
from repro.results.stored_loop import find_loop

EXPERIMENT = "swing_up"
FIGURES = {figure.name: figure for figure in load_figures(paper_folder())}
MOTIONS = {animation.name: animation.motion for animation in load_animations(paper_folder())}
STEPS = 80
TIME = 0.05 * np.arange(STEPS)


def motion_of(system, generator):
    """Random coordinates (steps, n_q)."""
    return np.cumsum(generator.normal(0, 0.1, (STEPS, system.n_q)), axis=0) + system.at_rest()


def stored(system, run="run-1", **others):
    """A loop of a system at random coordinates, its row and its motion as tables hold them."""
    q = motion_of(system, np.random.default_rng(0))
    series = {c.name: q[:, i] for i, c in enumerate(system.coordinates)}
    series |= {each.name: np.append(np.full(STEPS - 1, -each.limit), np.nan) for each in system.inputs}
    series["H"] = np.where(TIME < 3.5, 1.0, np.nan)  # given up after 3.5 s
    rows = [(name, t, v) for name, values in series.items() for t, v in zip(TIME, values, strict=True)]
    place = 0.7 if "x" in series else np.nan
    moving = pd.DataFrame(rows, columns=["name", "t", "value"]).assign(run=run, loop=0, member=0, x_des=place)
    chosen = {"system": system.name, "x_des": place, "experiment": EXPERIMENT, "held_from_s": 2.0, "adaptive": False}
    return loop(0, others.pop("success", True), run=run, **(chosen | others)), moving, q


@pytest.mark.parametrize("name", plugin_names(SYSTEMS))
def test_a_window_holds_all_that_is_drawn_and_what_is_removed_leaves_nothing(name):
    system = load(name)
    q = motion_of(system, np.random.default_rng(1))
    shapes = drawn_shapes(system, np.concatenate([q, 0 * q], axis=1))
    window = window_of(shapes, np.ones((STEPS, len(system.inputs))))
    panel = Figure().add_axes((0, 0, 1, 1))
    for step in (0, STEPS - 1):
        drawn = draw_shapes(panel, shapes, step, np.ones(len(system.inputs)), window.longest, shift=3.0)
        for artist in drawn:
            path = artist.get_path().transformed(artist.get_transform() - panel.transData)
            low, high = path.get_extents().get_points() - [3.0, 0.0]
            assert np.all(low >= window.middle - window.half) and np.all(high <= window.middle + window.half)
            artist.remove()
        assert not panel.lines and not panel.patches
    draw_goal(panel, at_steps(shapes, [3]))
    draw_track(panel, shapes)
    bodies = [shape for shape in shapes if shape.kind not in ("arrow", "turn")]
    assert len(panel.lines) + len(panel.patches) >= len(bodies)


def test_shapes_of_a_loop_are_those_of_its_system_and_its_goal():
    row, moving, q = stored(load("sip", L1=0.8))
    gathered = results([row], moving, EXPERIMENT, **{"system.L1": 0.8, "control.force_limit": None})
    found = find_loop(gathered, EXPERIMENT, [{"system": "sip"}])
    assert len(found.time) == np.sum(TIME < 3.5)
    shapes, goal, inputs = loop_shapes(found.settings, found.series, found.facts["x_des"])
    x, theta = q[: len(found.time)].T
    np.testing.assert_allclose(tip(shapes), np.stack([x + 0.8 * np.sin(theta), 0.8 * np.cos(theta)], axis=-1))
    np.testing.assert_allclose(tip(goal), [[0.7, 0.8]], atol=1e-15)
    np.testing.assert_array_equal(inputs, -1.0)


def test_the_goal_of_a_body_that_flies_has_all_of_its_places():
    row, moving, _ = stored(load("quadrotor"))
    goal_of = {"task.end": "hover", "task.goal.y": 0.5}
    gathered = results([row], moving, EXPERIMENT, **{"system.name": "quadrotor", "control.force_limit": 2.0}, **goal_of)
    shown = MOTIONS["swing_up_quadrotor"](gathered)
    body = next(shape for shape in shown.goal if shape.kind == "block")
    np.testing.assert_allclose(body.points[0, 0], [0.7, 0.5])
    np.testing.assert_allclose(shown.inputs, -3.0)  # of limits of 2 N, where the system has 6 N


def test_a_strip_shows_the_setting_that_succeeds_most_often_at_equal_time_steps():
    loops, motions = zip(
        *(stored(load("furuta"), run, success=run != "fixed", adaptive=run != "fixed", held_from_s=held)[:2]
          for run, held in (("fixed", 1.0), ("adaptive", 2.0))),
        strict=True,
    )  # fmt: skip
    gathered = results(loops, pd.concat(motions), EXPERIMENT, **{"system.name": "furuta", "control.force_limit": None})
    canvas = FIGURES["swing_up"].draw(gathered)
    (panel,) = canvas.axes
    assert "re-identified online: at its goal from 2.00 s on" in panel.get_title(loc="left")
    times = np.array([float(text.get_text().removesuffix(" s")) for text in panel.texts])
    assert times[0] == 0 and 2.0 <= times[-1] < 2.5
    np.testing.assert_allclose(np.diff(times), times[1])


def test_without_loops_there_is_no_strip_and_no_animation():
    nothing = results([])
    assert FIGURES["swing_up"].draw(nothing) is None
    assert [name for name, motion in MOTIONS.items() if motion(nothing) is not None] == []
