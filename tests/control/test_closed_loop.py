"""The loop on the true plant: exact, repeatable, and never stopped by what goes wrong in it."""

import numpy as np
import pytest
from cart_task import hanging_start, random_start

from repro.codegen.array_evaluation import evaluate
from repro.control.closed_loop import run_loop
from repro.control.conditions import Conditions
from repro.control.controller import ControlStep
from repro.control.geometry import Disc
from repro.control.predictive_controller import PredictiveController
from repro.control.solver import Limits, make_solver
from repro.control.task import Task
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate

DISC = Disc()


class Playing:
    """Plays forces whatever is measured, and stores its inputs."""

    def __init__(self, forces):
        self.forces, self.states, self.samples = list(forces), [], []

    def decide(self, state):
        self.states.append(state)
        return ControlStep(np.array([self.forces.pop(0)]))

    def observe(self, samples, inputs):
        self.samples.append((samples.copy(), inputs[:, 0]))


def play(system, forces, start, conditions=Conditions(), disc=DISC):  # noqa: B008 (frozen)
    controller, bounds = Playing(forces), Task(name="hanging").bounds(system)
    times = {"time_step": 0.04, "seconds": 0.04 * len(forces)}
    return controller, run_loop(system, controller, start, conditions, **times, disc=disc, bounds=bounds)


def test_the_plant_moves_as_simulated(system):
    forces = np.random.default_rng(0).uniform(-4, 4, 30)
    start = random_start(system, 0.8, 0, 0)
    controller, loop = play(system, forces, start)
    tau = np.stack([forces, np.zeros_like(forces)], axis=1)[None]
    motion = simulate(dynamics_of(system).acceleration, start.state[None], tau, 0.04)[0]
    np.testing.assert_allclose(loop.states[::8], motion, atol=1e-8)
    np.testing.assert_array_equal(controller.states, loop.states[:-1:8])
    np.testing.assert_array_equal(loop.inputs[:, 0], forces)
    assert loop.time[-1] == pytest.approx(1.2) and len(loop.clearance) == len(loop.time) == 241
    assert controller.samples[3][0].shape == (9, 4)


def test_a_delayed_force_begins_later(system):
    start = hanging_start(system, 0.8)
    controller, loop = play(system, [1.0, 2.0], start, Conditions(delay=0.015))
    np.testing.assert_array_equal(np.concatenate([f for _, f in controller.samples]), [*[0] * 3, *[1] * 8, *[2] * 5])
    np.testing.assert_allclose(loop.states[:4], np.tile(start.state, (4, 1)), atol=1e-12)


def test_disturbance_and_noise_repeat_and_differ_between_starts(system):
    conditions = Conditions(noise=1.0, disturbance=0.5)
    first, second = (random_start(system, 0.8, 0, number) for number in (0, 1))
    runs = [play(system, [0.0] * 20, start, conditions) for start in (first, first, second)]
    np.testing.assert_array_equal(runs[0][1].states, runs[1][1].states)
    np.testing.assert_array_equal(runs[0][0].states, runs[1][0].states)
    pushes = [np.diff(loop.states[:, 2])[:8].sum() for _, loop in runs]
    assert pushes[0] != pushes[2]
    away = np.array(runs[0][0].states) - runs[0][1].states[:-1:8]
    assert 0 < np.abs(away).max() < 0.1


def test_friction_of_the_plant_takes_energy(system):
    start = random_start(system, 0.8, 0, 0)
    energy = dynamics_of(system).hamiltonian
    for damping, least, most in (((), -1e-7, 1e-7), ((0.1, 0.01), -1.0, -1e-3)):
        _, loop = play(system, [0.0] * 50, start, Conditions(damping=damping))
        values = evaluate(energy, loop.states[:, :2], loop.states[:, 2:])[:, 0]
        assert least < values[-1] - values[0] < most


def test_a_runaway_is_stopped_and_counts_as_failure(system):
    _, loop = play(system, [4.0] * 250, hanging_start(system, 0.8))
    gone = np.isnan(loop.states[:, 0])
    assert gone[-1] and not gone[0] and np.nanmax(loop.states[:, 0]) <= 10.0
    assert len(loop.steps) < 250 and not loop.outcome.success


def test_the_single_pendulum_swings_up_past_the_obstacle(system, transcribe, problem):
    of = transcribe(problem)
    start = hanging_start(system, 0.4)
    solver = make_solver(of, "fatrop", Limits())
    controller = PredictiveController(of, solver, of.model.model.coefficients, start.goal.q)
    loop = run_loop(system, controller, start, Conditions(), time_step=0.04, seconds=6.0, disc=problem.obstacle)
    solver.close()
    assert loop.outcome.success and loop.outcome.held_from < 4.0 and 0 < loop.outcome.clearance < 0.05
    assert max(step.fallback for step in loop.steps) == 0
    assert np.abs(loop.inputs).max() <= 4.0 and len(loop.steps[0].plan) == 21
