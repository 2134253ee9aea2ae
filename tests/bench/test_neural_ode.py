"""Shooting through a neural ODE: the same equation of motion as the model's, and weights that come nearer."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from repro.bench.neural_ode import RECORDED, NeuralODE, race
from repro.data.random_force import random_force
from repro.evaluation.predictions import predict
from repro.mechanics.system import load
from repro.models.kinds.structured import Structured


def _rival(system: str, samples: int) -> NeuralODE:
    data = random_force(load(system), [3], replace(RECORDED, samples=samples))
    return NeuralODE(Structured(data.n_q, data.train.qd[0].std(0), hidden=(4,)), data)


@pytest.mark.parametrize("system", ["sip", "dip"])
def test_the_acceleration_is_that_of_the_model(system):
    rival, draw = _rival(system, 150), np.random.default_rng(0)
    weights = rival.model.initial([draw]) + 0.1 * draw.normal(size=(1, rival.model.n_parameters))
    motion = draw.normal(size=(4, 1, 20, rival.model.n_q))
    expected = predict(rival.model, weights, *motion).acceleration
    q, qd, _, tau = (torch.from_numpy(each[0]) for each in motion)
    found = rival.acceleration(torch.from_numpy(weights), q, qd, tau)
    np.testing.assert_allclose(found, expected[0], rtol=1e-9)


def test_shooting_learns():
    rival = _rival("sip", 600)
    start = rival.model.initial([np.random.default_rng(0)])[0]
    assert rival.error(rival.fitted(start, 10, 0)) < 0.95 * rival.error(start)


@pytest.mark.slow
def test_the_race_ends_at_the_patience():
    ticks = iter(range(10_000))
    pairs = race(range(1), 200, 1.0, lambda: float(next(ticks)))
    assert pairs.ours[0] == 1.0
    assert pairs.other[0] in (1.0, np.inf)
