"""Shooting through a neural ODE comes nearer the longer it trains, and the race ends at the patience."""

from dataclasses import replace

import numpy as np
import pytest

from repro.bench.neural_ode import RECORDED, by_path, by_shooting, race
from repro.data.random_force import random_force
from repro.mechanics.system import load

DATA = random_force(load("sip"), [3], replace(RECORDED, samples=600))


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
