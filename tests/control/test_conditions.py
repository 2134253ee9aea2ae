"""Starts, mismatch and noise: what they are, and that they can be repeated."""

import numpy as np
import pytest
from cart_task import hanging_start, random_start

from repro.control.conditions import Conditions, measured, plant_of, wrong_weights
from repro.mechanics.system import load

DIP = load("dip")


def test_random_starts_differ_and_repeat():
    one, again, next_one, other_seed = (
        random_start(DIP, 0.8, *numbers) for numbers in ((7, 0), (7, 0), (7, 1), (8, 0))
    )
    np.testing.assert_array_equal(one.state, again.state)
    for start in (one, again):
        assert (start.name, start.goal.place("x"), start.seed) == ("random 0", 0.8, (7, 0))
    assert not np.array_equal(one.state, next_one.state) and not np.array_equal(one.state, other_seed.state)


def test_random_starts_lie_around_hanging():
    away = np.abs(
        [start.state - hanging_start(DIP, 0.8).state for start in (random_start(DIP, 0.8, 0, k) for k in range(200))]
    )
    most = away.max(axis=0)
    bounds = np.array([0.3, 0.6, 0.6, 0.3, 0.3, 0.3])
    assert np.all(most <= bounds) and np.all(most > 0.9 * bounds)


def test_mismatch_of_coefficients_is_drawn_anew_for_every_start():
    starts = [random_start(DIP, 0.8, 3, k) for k in range(100)]
    conditions = Conditions(mismatch=0.2)
    factors = np.array([wrong_weights(np.ones(8), conditions, start) for start in starts])
    assert 0.8 <= factors.min() < 0.81 and 1.19 < factors.max() <= 1.2
    assert np.abs(np.corrcoef(factors.T) - np.eye(8)).max() < 0.4
    np.testing.assert_array_equal(factors[5], wrong_weights(np.ones(8), conditions, starts[5]))
    np.testing.assert_array_equal(wrong_weights(np.ones(8), Conditions(), starts[0]), np.ones(8))
    assert plant_of(DIP, conditions, starts[0]) == DIP


def test_physical_mismatch_is_the_plants():
    start = random_start(DIP, 0.8, 3, 0)
    conditions = Conditions(mismatch=0.1, mismatch_kind="physical", damping=(0.1, 0.002, 0.002))
    plant = plant_of(DIP, conditions, start)
    assert plant.g == DIP.g and plant.damping == (0.1, 0.002, 0.002)
    for constant in ("m0", "m1", "m2", "L1", "L2"):
        ratio = getattr(plant, constant) / getattr(DIP, constant)
        assert ratio != 1.0 and abs(ratio - 1) <= 0.1
    np.testing.assert_array_equal(wrong_weights(np.ones(8), conditions, start), np.ones(8))


def test_noise_has_its_standard_deviations():
    states = np.zeros((20_000, 6))
    observed = measured(states, DIP, 2.0, np.random.default_rng(0))
    np.testing.assert_allclose(observed.std(axis=0), 2 * np.array([1e-3, 1e-3, 1e-3, 5e-3, 1e-2, 1e-2]), rtol=0.03)
    assert measured(states, DIP, 0.0, np.random.default_rng(0)) is states


def test_a_hanging_start_is_the_papers():
    assert hanging_start(load("sip"), 0.8).state == pytest.approx([0, np.pi, 0, 0])
