"""The race to an accuracy, on a clock that ticks once a look."""

import itertools
import math

import numpy as np
import pytest
import torch

from repro.bench.accuracy import CONTINUED, OPTIMISERS, MemoryCheckpoint, Race, Racer, RaceSize
from repro.bench.training_case import lagrangian_case, triangular_case
from repro.learning.result import NoCheckpoint, silent
from repro.models.bases import t2

OURS = Racer("PLNN", "inverse", "Levenberg-Marquardt")
FORWARD = Racer("PLNN", "forward", "Levenberg-Marquardt")


@pytest.fixture(scope="module")
def case():
    return lagrangian_case(t2, (4,), 2, 200)


@pytest.fixture
def race(case):
    def start(threshold, patience=1.0, limit_s=0.5):
        ticks = itertools.count()
        models = {"PLNN": lambda: case, "DeLaN": lambda: triangular_case((4,), 2, 200)}
        size = RaceSize(list(OPTIMISERS), 2, 200, threshold, patience, limit_s)
        return Race(models, size, lambda: float(next(ticks)))

    return start


def test_what_is_good_enough_at_once_takes_one_budget(race):
    pairs = race(threshold=1e6).pairs(OURS, FORWARD)
    np.testing.assert_array_equal(pairs.ours, [1.0, 1.0])
    np.testing.assert_array_equal(pairs.ratios, [1.0, 1.0])


def test_what_is_never_good_enough_is_given_up(race):
    pairs = race(threshold=0.0).pairs(OURS, FORWARD)
    assert np.isinf(pairs.ours).all()
    assert np.isinf(pairs.other).all()


def test_the_forward_objective_is_judged_by_the_error_of_tau(race, case):
    found = race(threshold=1e6)
    model, data = case.model, case.dataset
    parameters = case.parameters[:1]
    problem = case.problem("forward").member(0)
    tau = model.evaluate(parameters, problem.tasks[0].prepared).tau.numpy()
    assert found.error("PLNN", parameters, 0) == pytest.approx(np.abs(tau - data.tau[:1]).mean())


@pytest.mark.parametrize("optimiser", CONTINUED)
def test_a_longer_training_begins_with_the_shorter_one(optimiser, case):
    """So that a budget can go on where the one before it ended."""
    build, budget = OPTIMISERS[optimiser]
    problem, start = case.problem("inverse").member(0), case.parameters[:1]
    kept = MemoryCheckpoint()
    build(budget).fit(problem, start, silent, kept)
    continued = build(2 * budget).fit(problem, start, silent, kept)
    whole = build(2 * budget).fit(problem, start, silent, NoCheckpoint())
    assert torch.equal(continued.parameters, whole.parameters)


@pytest.mark.parametrize("other", [Racer("PLNN", "inverse", "L-BFGS"), Racer("DeLaN", "inverse", "L-BFGS")])
def test_optimisers_and_models_are_paired_by_member(race, other):
    pairs = race(threshold=1e6).pairs(OURS, other)
    assert len(pairs) == 2
    assert all(math.isfinite(s) for s in [*pairs.ours, *pairs.other])


def test_a_racer_runs_once_however_often_it_is_compared(race):
    found = race(threshold=1e6)
    first = found.pairs(OURS, FORWARD).ours
    assert found.pairs(OURS, Racer("PLNN", "inverse", "L-BFGS")).ours is first
