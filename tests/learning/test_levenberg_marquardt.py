"""Levenberg-Marquardt: Gauss-Newton in the limit, a choice among starts, and its accuracy."""

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.evaluation.pointwise import pointwise
from repro.learning.members import products
from repro.learning.objective import Objective
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import t1, t2
from repro.models.gauge import Gauge
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian


def test_with_little_damping_a_linear_problem_takes_a_few_steps(t1_problem, start, true_t1):
    optimiser = LevenbergMarquardt(restarts=1, iterations=6, samples=None, damping=1e-3, damping_decrease=10)
    fitted = optimiser.fit(t1_problem, start(t1_problem.model), silent, NoCheckpoint())
    np.testing.assert_allclose(fitted.parameters.numpy(), np.tile(true_t1, (3, 1)), rtol=1e-9)


def test_the_best_of_several_starts_goes_on(make_problem, data, start):
    problem = make_problem(Lagrangian(t2, 2, hidden=(4,)), data)
    model, short = problem.model, LevenbergMarquardt(restarts=1, iterations=5, samples=None)
    first = start(model)
    others = [np.stack([model.initial([np.random.default_rng([s, 2, k])])[0] for s in range(3)]) for k in range(3)]
    tries = [
        short.fit(problem, candidate, silent, NoCheckpoint()).curves[-1][2]
        for candidate in (first, *map(torch.from_numpy, others))
    ]
    assert np.ptp(tries, axis=0).min() > 0
    scouted = LevenbergMarquardt(iterations=0, samples=None, restarts=4, trial_iterations=5)
    best = scouted.fit(problem, first, silent, NoCheckpoint()).curves[-1][2]
    np.testing.assert_array_equal(best, np.min(tries, axis=0))


def test_a_start_that_is_not_finite_is_passed_over(make_problem, data, start):
    problem = make_problem(Lagrangian(t2, 2, hidden=(4,)), data)
    broken = torch.full((3, problem.model.n_parameters), 1e308, dtype=torch.float64)
    fitted = LevenbergMarquardt(iterations=2, restarts=2, trial_iterations=1).fit(
        problem, broken, silent, NoCheckpoint()
    )
    assert fitted.status == ["ok"] * 3
    assert fitted.parameters.abs().max() < 1e3


def test_a_later_phase_does_not_look_for_another_start():
    assert LevenbergMarquardt(restarts=8).continued() == LevenbergMarquardt(restarts=1)


def test_it_stops_where_nothing_is_gained(t1_problem, true_t1):
    fitted = LevenbergMarquardt(restarts=1, iterations=500, samples=None).fit(
        t1_problem, torch.from_numpy(np.tile(true_t1, (3, 1))), silent, NoCheckpoint()
    )
    assert len(fitted.curves) < 60


@pytest.fixture(scope="module")
def episodes(system):
    return random_force(system, seeds=[0, 1], samples=5000, episode_steps=100)


def _test_error(model, data, system, optimiser):
    parameters = torch.from_numpy(model.initial([np.random.default_rng([seed, 1]) for seed in (0, 1)]))
    problem = TrainingProblem(model, [make_task(model, data.train, Objective())], [0, 1])
    fitted = optimiser.fit(problem, parameters, silent, NoCheckpoint())
    metrics = {m.name: m.values for m in pointwise(model, fitted.parameters, data.test, system, "test", Gauge.RAW)}
    return metrics["mae_tau"]


def test_the_papers_network_reaches_a_tenth_of_the_papers_error(episodes, system):
    """1x10 on T2; the paper's Adam reports MAE_tau 0.26."""
    optimiser = LevenbergMarquardt(iterations=150, samples=1000, restarts=8, trial_iterations=30)
    errors = _test_error(Lagrangian(t2, 2, hidden=(10,)), episodes, system, optimiser)
    assert np.all(errors < 0.02)


def test_a_model_that_contains_the_truth_finds_it(episodes, system):
    model = Structured(2, np.array([0.9, 5.0]), structured.Options(hidden=(8,)))
    errors = _test_error(
        model, episodes, system, LevenbergMarquardt(restarts=1, iterations=80, samples=500, damping_decrease=10)
    )
    assert np.all(errors < 1e-5)


def test_t1_is_the_case_where_it_is_gauss_newton(episodes, system):
    errors = _test_error(
        Lagrangian(t1, 2), episodes, system, LevenbergMarquardt(restarts=1, iterations=20, damping_decrease=10)
    )
    assert np.all(errors < 1e-9)


def test_every_start_has_the_weights_that_a_model_brings_along(make_problem, data):
    from repro.models.interconnection import Interconnection, Joined

    given = np.array([0.2, 0.01, 0.05, 0.5]) * np.arange(1, 4)[:, None] / 3
    rest = Structured(2, np.array([0.9, 5.0]), structured.Options(hidden=(2,)))
    model = Interconnection([Joined(Lagrangian(t1, 2), lambda q: q), Joined(rest, lambda q: q)], 2, given)
    start = torch.from_numpy(model.initial([np.random.default_rng(seed) for seed in range(3)]))
    optimiser = LevenbergMarquardt(iterations=3, restarts=3, trial_iterations=2)
    fitted = optimiser.fit(make_problem(model, data), start, silent, NoCheckpoint())
    np.testing.assert_array_equal(fitted.parameters[:, :4], given)
    assert (fitted.parameters[:, 4:] != start[:, 4:]).any(1).all()


@pytest.mark.parametrize("zeros", [0, 100, 1920, 4100, 6000])
@pytest.mark.parametrize("late", [0, 3, 8])
def test_products_leave_out_zeros(zeros, late):
    """J'J is the same where it skips the rows in which the columns from `late` on are 0."""
    generator = np.random.default_rng(0)
    jacobian = generator.normal(size=(6000, 11)) * 10.0 ** generator.integers(-3, 4, 11)
    jacobian[:zeros, late:] = 0
    given = jacobian.copy()
    expected = given.T @ given
    np.testing.assert_allclose(products(jacobian, late), expected, rtol=1e-12, atol=1e-14 * np.abs(expected).max())
    np.testing.assert_array_equal(jacobian, given)
