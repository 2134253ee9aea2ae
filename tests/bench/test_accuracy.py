"""The race to an accuracy, on a clock that ticks once a look."""

import itertools
import math

import numpy as np
import pytest

from repro.bench.accuracy import Race
from repro.bench.case import lagrangian_case
from repro.models.bases import t2


@pytest.fixture(scope="module")
def case():
    return lagrangian_case(t2, (4,), 2, 200)


@pytest.fixture
def race(case):
    def start(threshold, patience=1.0, limit_s=0.5):
        ticks = itertools.count()
        return Race(lambda: case, threshold, patience, limit_s, lambda: float(next(ticks)))

    return start


def test_what_is_good_enough_at_once_takes_one_budget(race):
    pairs = race(threshold=1e6).forward_against_inverse("Levenberg-Marquardt")
    np.testing.assert_array_equal(pairs.ours, [1.0, 1.0])
    np.testing.assert_array_equal(pairs.ratios, [1.0, 1.0])


def test_what_is_never_good_enough_is_given_up(race):
    pairs = race(threshold=0.0).forward_against_inverse("Levenberg-Marquardt")
    assert np.isinf(pairs.ours).all()
    assert np.isinf(pairs.other).all()


def test_the_forward_objective_is_judged_by_the_error_of_tau(race, case):
    found = race(threshold=1e6)
    model, data = case.model, case.dataset
    parameters = case.parameters[:1]
    problem = case.problem("forward").member(0)
    tau = model.evaluate(parameters, problem.tasks[0].prepared).tau.numpy()
    assert found.error(parameters, 0) == pytest.approx(np.abs(tau - data.tau[:1]).mean())


def test_optimisers_of_the_inverse_objective_are_paired_by_member(race):
    pairs = race(threshold=1e6).optimisers("Levenberg-Marquardt", "L-BFGS")
    assert len(pairs) == 2
    assert all(math.isfinite(s) for s in [*pairs.ours, *pairs.other])
