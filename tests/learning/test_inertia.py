"""The least eigenvalue of the mass matrix on the way: a closed form, every optimiser, every member its own."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from repro.learning.optimisers.adam import Adam
from repro.learning.optimisers.lbfgs import LBFGS
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import Phase, train
from repro.learning.watch import InertiaWatch
from repro.models.terms import least_eigenvalue


@pytest.fixture
def watched(t1_problem, data):
    return replace(t1_problem, watches=[InertiaWatch.over(t1_problem.model, data.test)])


def test_it_is_that_of_the_true_system_at_the_true_coefficients(watched, data, true_t1):
    (watch,) = watched.watches
    half_mass, half_inertia, coupling, _ = true_t1
    corner = coupling * np.cos(data.test.q[..., 1])
    least = half_mass + half_inertia - np.sqrt((half_mass - half_inertia) ** 2 + corner**2)
    found = watch(torch.from_numpy(np.tile(true_t1, (3, 1))))
    np.testing.assert_allclose(found, least.min(1), rtol=1e-12)


@pytest.mark.parametrize(
    "optimiser", [LevenbergMarquardt(restarts=1, iterations=20), LBFGS(iterations=20), Adam(epochs=20)]
)
def test_every_optimiser_tells_it_now_and_then(optimiser, watched, start):
    (watch,) = watched.watches
    fitted = train([Phase("D", watched)], optimiser, start(watched.model))
    told = {step: values for step, name, values in fitted.curves if name == "min_eig_M"}
    losses = {step for step, name, _ in fitted.curves if name == "loss"}
    assert set(told) <= losses
    if isinstance(optimiser, Adam):
        np.testing.assert_array_equal(told[20], watch(fitted.parameters))
    else:
        np.testing.assert_array_equal(told[0], watch(start(watched.model)))
        assert {step % 10 for step in told} == {0}


def test_trials_of_random_starts_are_not_watched(watched, start):
    """They may take more iterations than the fit, which would then be drawn with values of another start."""
    optimiser = LevenbergMarquardt(restarts=3, trial_iterations=30, iterations=12)
    curves = optimiser.fit(watched, start(watched.model), silent, NoCheckpoint()).curves
    assert max(step for step, name, _ in curves if name == "min_eig_M") <= 12


def test_a_later_phase_begins_at_the_last_step_of_the_loss(watched, start):
    """Also where what is watched now and then was last seen some steps before."""
    optimiser = LevenbergMarquardt(restarts=1, iterations=7, tolerance=0.0)
    fitted = train([Phase("first", watched), Phase("second", watched)], optimiser, start(watched.model))
    assert [step for step, name, _ in fitted.curves if name == "loss"] == [*range(8), *range(7, 15)]
    assert [step for step, name, _ in fitted.curves if name == "min_eig_M"] == [0, 7]


def test_a_member_is_watched_at_its_own_states(watched, start):
    (watch,) = watched.watches
    weights = start(watched.model)
    alone = [watch.member(number)(weights[number : number + 1])[0] for number in range(3)]
    np.testing.assert_allclose(alone, watch(weights), rtol=1e-12)
    assert len(set(alone)) == 3


def test_an_optimiser_that_never_looks_tells_nothing(watched, start):
    class Stay(LBFGS):
        def solve(self, problem, start, progress):
            return start, [1.0], "ok"

    fitted = Stay().fit(watched, start(watched.model), silent, NoCheckpoint())
    assert {name for _, name, _ in fitted.curves} == {"loss"}


def test_watching_changes_nothing(watched, t1_problem, start):
    fits = [
        LevenbergMarquardt(restarts=1, iterations=3).fit(problem, start(problem.model), silent, NoCheckpoint())
        for problem in (watched, t1_problem)
    ]
    np.testing.assert_array_equal(*(each.parameters.numpy() for each in fits))


def test_a_matrix_that_is_not_finite_counts_as_singular():
    mass = np.broadcast_to(np.eye(2), (2, 3, 2, 2)).copy()
    mass[1, 0, 0, 1] = np.inf
    np.testing.assert_array_equal(least_eigenvalue(mass), [1, 0])
