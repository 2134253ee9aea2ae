"""Starts, mismatch and noise: what they are, and that they can be repeated."""

import numpy as np
import pytest

from repro.control.conditions import Conditions, hanging_start, measured, plant_of, random_starts, wrong_weights
from repro.mechanics.system import load

DIP = load("dip")


def test_a_start_does_not_depend_on_how_many_there_are():
    few, many = (random_starts(DIP, (0.8, -0.8), count, 7) for count in (3, 9))
    for one, other in zip(few, many, strict=False):
        np.testing.assert_array_equal(one.state, other.state)
        assert (one.name, one.x_des, one.seed) == (other.name, other.x_des, other.seed)
    assert [start.x_des for start in few] == [0.8, -0.8, 0.8]
    assert not np.array_equal(few[0].state, random_starts(DIP, (0.8,), 1, 8)[0].state)


def test_random_starts_lie_around_hanging():
    away = np.abs([start.state - hanging_start(DIP, 0.8).state for start in random_starts(DIP, (0.8,), 200, 0)])
    most = away.max(axis=0)
    bounds = np.array([0.3, 0.6, 0.6, 0.3, 0.3, 0.3])
    assert np.all(most <= bounds) and np.all(most > 0.9 * bounds)


def test_mismatch_of_coefficients_is_drawn_anew_for_every_start():
    starts = random_starts(DIP, (0.8,), 100, 3)
    conditions = Conditions(mismatch=0.2)
    factors = np.array([wrong_weights(np.ones(8), conditions, start) for start in starts])
    assert 0.8 <= factors.min() < 0.81 and 1.19 < factors.max() <= 1.2
    assert np.abs(np.corrcoef(factors.T) - np.eye(8)).max() < 0.4
    np.testing.assert_array_equal(factors[5], wrong_weights(np.ones(8), conditions, starts[5]))
    np.testing.assert_array_equal(wrong_weights(np.ones(8), Conditions(), starts[0]), np.ones(8))
    assert plant_of(DIP, conditions, starts[0]) == DIP


def test_physical_mismatch_is_the_plants():
    start = random_starts(DIP, (0.8,), 1, 3)[0]
    conditions = Conditions(mismatch=0.1, mismatch_kind="physical", damping=(0.1, 0.002, 0.002))
    plant = plant_of(DIP, conditions, start)
    assert plant.g == DIP.g and plant.damping == (0.1, 0.002, 0.002)
    for constant in ("m0", "m1", "m2", "L1", "L2"):
        ratio = getattr(plant, constant) / getattr(DIP, constant)
        assert ratio != 1.0 and abs(ratio - 1) <= 0.1
    np.testing.assert_array_equal(wrong_weights(np.ones(8), conditions, start), np.ones(8))


def test_noise_has_its_standard_deviations():
    states = np.zeros((20_000, 6))
    seen = measured(states, DIP, 2.0, np.random.default_rng(0))
    np.testing.assert_allclose(seen.std(axis=0), 2 * np.array([1e-3, 1e-3, 1e-3, 5e-3, 1e-2, 1e-2]), rtol=0.03)
    assert measured(states, DIP, 0.0, np.random.default_rng(0)) is states


def test_a_hanging_start_is_the_papers():
    assert hanging_start(load("sip"), 0.8).state == pytest.approx([0, np.pi, 0, 0])
