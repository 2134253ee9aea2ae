"""Closed-form least squares: the oracle, and what it does where the data do not decide."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.learning.objective import Objective
from repro.learning.optimisers.least_squares import LeastSquares, regression, solve
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import library, t1
from repro.models.lagrangian import Lagrangian

TWICE = SimpleNamespace(
    LINEAR=True,
    kinetic=lambda q, qd, m: t1.kinetic(q, qd, m) | {"the cart again": 3 * qd[0] ** 2},
    potential=t1.potential,
)


def _fit(problem):
    parameters = torch.zeros(problem.members, problem.model.n_parameters, dtype=torch.float64)
    return LeastSquares().fit(problem, parameters, silent, NoCheckpoint())


@pytest.mark.parametrize("regime", ["episodes", "long"])
def test_it_recovers_the_true_coefficients(regime, system, make_problem, true_t1):
    data = random_force(system, seeds=[0, 1, 2], samples=300, regime=regime, episode_steps=100)
    fitted = _fit(make_problem(Lagrangian(t1, 2), data))
    np.testing.assert_allclose(fitted.parameters, np.tile(true_t1, (3, 1)), rtol=0, atol=1e-12)
    assert fitted.notes["rank"] == [4, 4, 4]


@pytest.mark.parametrize("form", ["legendre", "sum"])
def test_known_energies_of_free_motion_leave_one_combination_open(form, data, free, true_t1):
    """From rest p_x stays 0, so xd = -k thetad cos(theta): T tells k a - b only. Forces decide the rest."""
    model, k = Lagrangian(t1, 2), true_t1[2] / (2 * true_t1[0])
    energy = make_task(model, free.train, Objective(None, energy_weight=2.0, energy_form=form))
    alone = _fit(TrainingProblem(model, [energy], [0, 1, 2])).parameters
    np.testing.assert_allclose(alone[:, [1, 3]], np.tile(true_t1[[1, 3]], (3, 1)), atol=1e-6)
    np.testing.assert_allclose(k * alone[:, 0] - alone[:, 2], k * true_t1[0] - true_t1[2], atol=1e-6)
    assert np.abs(alone[:, 0] - true_t1[0]).min() > 0.1
    joint = _fit(TrainingProblem(model, [make_task(model, data.train, Objective()), energy], [0, 1, 2]))
    np.testing.assert_allclose(joint.parameters, np.tile(true_t1, (3, 1)), atol=1e-9)


def test_the_rank_says_how_much_the_data_decide(make_problem, data):
    fitted = _fit(make_problem(Lagrangian(TWICE, 2), data))
    assert fitted.notes["rank"] == [4, 4, 4]
    assert _fit(make_problem(Lagrangian(library, 2), data)).notes["rank"] == [32, 32, 32]


def test_of_equal_columns_each_takes_its_share(make_problem, data, true_t1):
    """Minimum norm on unit columns: xd^2 and 3 xd^2 carry half of the signal each."""
    solution = _fit(make_problem(Lagrangian(TWICE, 2), data)).parameters[0]
    assert solution[0] == pytest.approx(true_t1[0] / 2, rel=1e-10)
    assert solution[3] == pytest.approx(true_t1[0] / 6, rel=1e-10)


def test_gauge_columns_get_nothing(make_problem, data):
    """A total derivative such as thetad cos(theta) does not show in tau."""
    model = Lagrangian(library, 2)
    solution = dict(zip(model.coefficient_names, _fit(make_problem(model, data)).parameters[0].tolist(), strict=True))
    assert abs(solution["xd^0 thetad^1 cos(theta)"]) < 1e-9
    assert solution["xd^2 thetad^0 1"] == pytest.approx(0.4, abs=1e-6)


def test_terms_that_are_total_derivatives_are_columns_of_exact_zeros(make_problem, data):
    """Not of rounding, which scaled to unit norm would count as a term that the data show."""
    model = Lagrangian(library, 2)
    matrix, _ = regression(make_problem(model, data), 0)
    gauge = [name for name, column in zip(model.coefficient_names, matrix.T, strict=True) if not column.any()]
    assert "xd^0 thetad^1 cos(theta)" in gauge
    assert all(np.linalg.norm(column) > 1e-6 for column in matrix.T if column.any())


def test_solve_is_the_pseudo_inverse_of_the_unit_columns():
    random = np.random.default_rng(0)
    matrix = random.normal(size=(40, 6)) * 10.0 ** np.arange(6)
    matrix[:, 5] = matrix[:, 4] - matrix[:, 3]
    right = random.normal(size=40)
    norms = np.linalg.norm(matrix, axis=0)
    solution, rank = solve(matrix, right, 1e-12)
    assert rank == 5
    np.testing.assert_allclose(solution * norms, np.linalg.pinv(matrix / norms, rcond=1e-12) @ right, rtol=1e-8)


def test_the_regression_is_the_residual(t1_problem, start):
    matrix, right = regression(t1_problem, 0)
    weights = start(t1_problem.model)
    residual = matrix @ weights[0].numpy() - right
    assert residual @ residual == pytest.approx(t1_problem.loss(weights)[0].item(), rel=1e-12)


def test_what_the_data_do_not_show_stays_at_the_start_if_asked(make_problem, data, true_t1):
    """The nearest of all solutions in columns of unit norm: xd^2 and 3 xd^2 are moved alike."""
    problem = make_problem(Lagrangian(TWICE, 2), data)
    start = torch.tensor([[3.0, 0.0, 0.0, -2.0, 0.0]] * 3, dtype=torch.float64)
    near, zero = (
        LeastSquares(regularise_towards=place).fit(problem, start, silent, NoCheckpoint()).parameters
        for place in ("start", "zero")
    )
    np.testing.assert_allclose(near[:, 0] + 3 * near[:, 3], true_t1[0], atol=1e-12)
    np.testing.assert_allclose(near[:, 0] - 3 * near[:, 3], 3 + 6, atol=1e-12)
    np.testing.assert_allclose(zero[:, 0] - 3 * zero[:, 3], 0, atol=1e-12)
    assert LeastSquares().continued() == LeastSquares(regularise_towards="start")


def test_a_direction_below_the_cutoff_is_not_followed():
    matrix = np.array([[1.0, 1.0], [0.0, 1e-6], [0.0, 0.0]])
    right = np.array([1.0, 1.0, 0.0])
    assert solve(matrix, right, 1e-8)[1] == 2 and np.abs(solve(matrix, right, 1e-8)[0]).max() > 1e5
    solution, rank = solve(matrix, right, 1e-4)
    assert rank == 1
    np.testing.assert_allclose(solution, [0.5, 0.5], atol=1e-5)
