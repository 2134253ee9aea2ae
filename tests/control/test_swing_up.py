"""Loops of mechanisms without a cart: a weak motor pumps its pendulum up, and two thrusts carry a body to a point."""

from dataclasses import replace

import numpy as np
import pytest

from repro.config.registry import settings
from repro.control.closed_loop import run_loop
from repro.control.controller import CONTROLLERS, ControlStep
from repro.control.predictive_model import PredictiveModel
from repro.control.task import Task
from repro.mechanics.inputs import input_limits
from repro.mechanics.system import load
from repro.models.kinds.truth import true_model
from repro.plugins.checked import checked
from repro.plugins.plugin import plugin


def driven(system, control, task):
    """The first random start of a task, driven with the true model."""
    options = checked("control", CONTROLLERS, settings("control", control))
    model = PredictiveModel(true_model(system, damped=False), system)
    (weights,) = model.model.initial([np.random.default_rng(0)])
    (start, _), *_ = task.starts(system, 1)
    samples = np.zeros((3, 1, system.n_q))
    with plugin(CONTROLLERS, options.kind).build(options, model, None, samples) as make:
        return run_loop(
            system, make(weights, start.goal), start, task,
            time_step=options.time_step, seconds=task.seconds, disc=None, bounds=task.bounds(system),
        )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "control", "task"),
    [
        ("torque_pendulum", "swing_up", "swing_up"),
        ("pendubot", "swing_up_links", "swing_up"),
        ("quadrotor", "fly", "fly"),
    ],
)
def test_the_goal_is_reached_and_held_within_the_limits(name, control, task):
    system = load(name)
    loop = driven(system, control, Task(**settings("task", task) | {"start_seed": 5}))
    assert loop.outcome.success and loop.outcome.held_from < 6.0
    assert np.all(np.abs(loop.inputs) <= input_limits(system))


def test_a_loop_beyond_its_limits_is_given_up():
    """The thrusts of hovering on a body that stands on its head: it falls out of its box."""
    system = load("quadrotor")
    task = Task(**settings("task", "fly") | {"limits": {"m": 2.0, "rate": 60.0}, "seconds": 4.0, "initial_states": 1})
    (start, _), *_ = task.starts(system, 1)
    fallen = replace(start, state=np.array([0.0, 0.0, np.pi, 0.0, 0.0, 0.0]))

    class Hovering:
        def decide(self, state):
            return ControlStep(np.full(2, system.m1 * system.g / 2))

        def observe(self, samples, inputs):
            assert samples.shape == (9, 6) and inputs.shape == (8, 2)

    loop = run_loop(
        system, Hovering(), fallen, task, time_step=0.04, seconds=4.0, disc=None, bounds=task.bounds(system)
    )
    gone = np.isnan(loop.states[:, 0])
    assert gone[-1] and np.nanmin(loop.states[:, 1]) >= -2.0 and not loop.outcome.success
