"""Shooting through a neural ODE: the same equation of motion as the model's, and weights that come nearer."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from repro.bench.neural_ode import RECORDED, NeuralODE, by_path, by_shooting, race
from repro.data.random_force import random_force
from repro.evaluation.predictions import predict
from repro.mechanics.system import load
from repro.models.kinds.structured import Options

DATA = random_force(load("sip"), [3], replace(RECORDED, samples=600))


@pytest.mark.parametrize("n_q", [2, 3])
def test_the_acceleration_is_that_of_the_model(n_q):
    draw = np.random.default_rng(0)
    rival = NeuralODE(n_q, 1 + draw.uniform(size=n_q), Options(hidden=(4,)))
    weights = rival.initial([draw]) + 0.1 * draw.normal(size=(1, rival.n_parameters))
    motion = draw.normal(size=(4, 1, 20, n_q))
    q, qd, _, tau = (torch.from_numpy(each) for each in motion)
    found = rival.acceleration_at(torch.from_numpy(weights), q, qd, tau)
    np.testing.assert_allclose(found, predict(rival, weights, *motion).acceleration, rtol=1e-9)


def test_shooting_learns():
    assert by_shooting(DATA, 0, 0.3) < 0.95 * by_shooting(DATA, 0, 1e-9)


@pytest.mark.slow
def test_the_path_fit_learns():
    assert by_path(DATA, 0) < 0.1 * np.abs(DATA.test.qdd).mean()


@pytest.mark.slow
def test_the_race_ends_at_the_patience():
    ticks = iter(range(10_000))
    pairs = race(range(1), 200, 1.0, lambda: float(next(ticks)))
    assert pairs.ours[0] == 1.0
    assert pairs.other[0] in (1.0, np.inf)
