"""Rank, condition and null directions: of matrices made by hand, and of the paper's data."""

import numpy as np
import pytest
from simulated import free_motion, random_force

from repro.evaluation.identifiability import identifiability
from repro.learning.objective import Objective
from repro.learning.optimisers.least_squares import regression
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import fxf, fxf_gauge, library, t1
from repro.models.lagrangian import Lagrangian

TAU, WITH_ENERGY = Objective(), Objective(energy_weight=1.0, energy_form="sum")
IDENTITIES = {f"(theta{i}d sin(theta{i}))^2 + (theta{i}d cos(theta{i}))^2 - theta{i}d^2" for i in (1, 2)}
CART_MOMENTUM = "(xd + 0.15 theta1d cos(theta1) + 0.05 theta2d cos(theta2))^2"


@pytest.fixture(scope="module")
def dip():
    return load("dip")


@pytest.fixture(scope="module")
def forced(dip):
    return random_force(dip, seeds=[0], samples=1000, episode_steps=100, force_limit=4.0)


@pytest.fixture(scope="module")
def free(dip):
    return free_motion(dip, seeds=[0], initial_angles=10)


def _examined(basis, *tasks):
    model = Lagrangian(basis, tasks[0][0].n_q)
    problem = TrainingProblem(model, [make_task(model, data.train, objective) for data, objective in tasks], [0])
    matrix, _ = regression(problem, 0)
    return identifiability(matrix, model.coefficient_names, len(model.kinetic_features))


def test_of_a_matrix_made_by_hand():
    rows = np.random.default_rng(0).normal(size=(50, 3)) * [1, 1e-3, 1e3]
    matrix = np.column_stack([rows, rows[:, 0] - 2 * rows[:, 1], np.zeros(50)])
    found = identifiability(matrix, ["a", "b", "c", "d", "e"], 4)
    assert found.rank == 3 and len(found.null_directions) == 2
    assert np.abs(matrix @ found.null_directions.T).max() < 1e-12
    assert found.words == ("V: e", "-0.5 a + b + 0.5 d")
    values = np.linalg.svd(matrix, compute_uv=False)
    assert found.condition_raw == pytest.approx(values[0] / values[2])
    assert found.condition_scaled < 5 and found.condition_raw > 1e5


def test_a_matrix_with_fewer_rows_than_columns():
    found = identifiability(np.array([[1.0, 1.0, 0.0]]), ["a", "b", "c"], 3)
    assert found.rank == 1 and set(found.words) == {"c", "a - b"}


def test_nothing_is_seen_in_zeros():
    found = identifiability(np.zeros((4, 2)), ["a", "b"], 1)
    assert found.rank == 0 and set(found.words) == {"a", "V: b"} and np.isinf(found.condition_raw)


@pytest.mark.parametrize("samples", [20, 800])
def test_forces_under_a_random_input_leave_two_identities_only(samples, dip):
    data = random_force(dip, seeds=[0], samples=samples * 5 // 4, force_limit=4.0)
    found = _examined(fxf, (data, TAU))
    assert found.rank == 28 and set(found.words) == IDENTITIES


def test_free_motion_with_known_energy_does_not_see_the_cart_momentum(free):
    found = _examined(fxf, (free, WITH_ENERGY))
    assert found.rank == 27 and set(found.words) == IDENTITIES | {CART_MOMENTUM}
    direction = dict(zip(found.names, found.null_directions[found.words.index(CART_MOMENTUM)], strict=True))
    a, b = "theta1d cos(theta1)", "theta2d cos(theta2)"
    expected = {
        "xd^2": 1,
        f"xd * {a}": 0.3,
        f"xd * {b}": 0.1,
        f"({a})^2": 0.0225,
        f"{a} * {b}": 0.015,
        f"({b})^2": 0.0025,
    }
    assert {name for name, value in direction.items() if value} == set(expected)
    for name, value in expected.items():
        assert direction[name] == pytest.approx(value, abs=1e-6)


def test_without_its_energy_the_scale_of_the_lagrangian_is_open_too(free):
    found = _examined(fxf, (free, TAU))
    assert found.rank == 26 and IDENTITIES | {CART_MOMENTUM} < set(found.words)
    (scale,) = (words for words in found.words if words not in IDENTITIES | {CART_MOMENTUM})
    assert "V: cos(theta1) + 0.333333 cos(theta2)" in scale


@pytest.mark.parametrize(("starts", "grid"), [(10, "diagonal"), (40, "diagonal"), (25, "product")])
def test_the_reading_of_the_grid_does_not_matter(starts, grid, dip):
    found = _examined(fxf, (free_motion(dip, seeds=[0], initial_angles=starts, grid=grid), WITH_ENERGY))
    assert found.rank == 27 and CART_MOMENTUM in found.words


@pytest.mark.slow
def test_nor_does_the_full_grid(dip):
    found = _examined(fxf, (free_motion(dip, seeds=[0], initial_angles=100), WITH_ENERGY))
    assert found.rank == 27 and CART_MOMENTUM in found.words


def test_together_forces_and_energies_leave_the_momentum_as_a_gauge(forced, free):
    """p_x is a total derivative, so no force shows it, and it vanishes in all free motion from rest."""
    assert _examined(fxf, (forced, TAU), (free, WITH_ENERGY)).rank == 28
    found = _examined(fxf_gauge, (forced, TAU), (free, WITH_ENERGY))
    assert found.rank == 37
    assert set(found.words) == IDENTITIES | {CART_MOMENTUM.removesuffix(")^2").removeprefix("(")}


def test_forces_leave_every_gauge_term(forced):
    found = _examined(fxf_gauge, (forced, TAU))
    split = {f"T: cos(theta{i}), V: cos(theta{i})" for i in (1, 2)}
    linear = {"xd", *(f"theta{i}d{factor}" for i in (1, 2) for factor in ("", f" sin(theta{i})", f" cos(theta{i})"))}
    assert found.rank == 28 and set(found.words) == IDENTITIES | split | linear | {"1"}


def test_the_single_pendulum():
    sip = load("sip")
    data, free = random_force(sip, seeds=[0], samples=400), free_motion(sip, seeds=[0], initial_angles=20)
    assert _examined(t1, (data, TAU)).rank == 4
    assert _examined(t1, (free, WITH_ENERGY)).rank == 4
    energy_alone = _examined(t1, (free, Objective(None, energy_weight=1.0)))
    assert energy_alone.rank == 3 and energy_alone.words == ("xd^2 + 0.125 xd thetad cos(theta)",)
    assert _examined(library, (data, TAU)).rank == 32


def test_scaling_the_columns_helps(forced):
    found = _examined(fxf, (forced, TAU))
    assert found.condition_scaled < found.condition_raw / 10
    assert found.singular_values[0] == 1 and np.all(np.diff(found.singular_values) <= 0)
    assert found.singular_values[found.rank - 1] == pytest.approx(1 / found.condition_scaled)
