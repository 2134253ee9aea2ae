"""Goals by unit and by name, and what a task says of a system that it does not fit."""

import numpy as np
import pytest

from repro.config.registry import settings
from repro.control.controller import ControllerOptions
from repro.control.task import Task
from repro.mechanics.system import load


def task(name, **changes):
    return Task(**settings("task", name) | changes)


def test_the_papers_task_is_the_default():
    assert Task(name="hanging").plain() == task("hanging").plain()


def test_a_goal_is_reached_within_every_tolerance_and_free_coordinates_do_not_count():
    furuta = load("furuta")
    (goal,) = task("swing_up", tolerance={"deg": 5.0, "phi": 0.1}).goals(furuta)
    state = np.array([2 * np.pi + 0.09, -0.08, 3.0, -9.0])
    assert goal.reached(state) and not goal.reached(np.add(state, [0.02, 0, 0, 0])) and not goal.reached(state * np.nan)
    (free,) = task("swing_up", tolerance={"deg": 5.0, "phi": None}).goals(furuta)
    assert free.reached(np.add(state, [3.0, 0, 0, 0])) and not free.reached(state - [0.0, 0.01, 0, 0])


def test_places_and_further_coordinates_of_a_goal():
    chosen = task("swing_up", start="hover", end="hover", x_des=(1.0, -1.0), goal={"y": 0.5})
    goals = chosen.goals(load("quadrotor"))
    np.testing.assert_array_equal([goal.q for goal in goals], [[1.0, 0.5, 0.0], [-1.0, 0.5, 0.0]])
    assert [goal.place("y") for goal in goals] == [0.5, 0.5] and np.isnan(goals[0].place("phi"))


def test_spreads_and_bounds_by_name_come_before_those_by_unit():
    furuta = load("furuta")
    chosen = task("swing_up", spread={"rad": 0.6, "phi": 0.1, "rate": 0.3}, limits={"phi": 9.0, "rate": 60.0})
    (goal,) = chosen.goals(furuta)
    away = np.abs([chosen.random_start(furuta, goal, k).state - [0, np.pi, 0, 0] for k in range(200)])
    most = away.max(axis=0)
    assert np.all(most <= [0.1, 0.6, 0.3, 0.3]) and np.all(most > [0.09, 0.55, 0.27, 0.27])
    np.testing.assert_array_equal(chosen.bounds(furuta), [9.0, np.inf, 60.0, 60.0])


@pytest.mark.parametrize(
    ("system", "changes", "told"),
    [
        ("acrobot", {"x_des": (0.8,)}, "task.x_des = [0.8]: system=acrobot has no coordinate x, only theta1, theta2"),
        ("acrobot", {"goal": {"x": 0.8}}, "task.goal.x: system=acrobot has coordinates theta1, theta2"),
        ("acrobot", {"goal": {"m": 0.8}}, "task.goal.m: system=acrobot"),
        ("acrobot", {"limits": {"phi": 1.0}}, "task.limits.phi: system=acrobot"),
        ("quadrotor", {}, "task.start = 'hanging': system=quadrotor rests at hover"),
    ],
)
def test_what_does_not_fit_a_system_is_a_line(system, changes, told):
    assert next(task("swing_up", **changes).problems(load(system), ControllerOptions())).startswith(told)


def test_swing_up_fits_pendulums():
    for name in ("torque_pendulum", "acrobot", "pendubot", "furuta", "dip"):
        assert [*task("swing_up").problems(load(name), ControllerOptions())] == []
