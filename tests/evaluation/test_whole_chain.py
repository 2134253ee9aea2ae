"""A chain learned as a whole: exact without noise, and needs far more samples than a link that is learned alone."""

import numpy as np
import pytest
from simulated import random_force

from repro.evaluation.chains import simulate_chain
from repro.evaluation.whole_chain import draw, follow, learn, whole_chain_errors
from repro.mechanics.system import load
from repro.models.ports import ChainLink

LINK = load("link", damping=[0.3])


@pytest.fixture(scope="module")
def data():
    return random_force(LINK, seeds=[0, 1], samples=500, episode_steps=50, reset="random")


def test_without_noise_the_true_matrices_are_found(data):
    samples = draw(ChainLink.true(LINK), data.train, 0, 3, 0.0, np.random.default_rng(0))
    mass, spring, cubic, damping = np.split(learn(samples).T, 4, axis=1)
    incidence = np.eye(3) - np.eye(3, k=-1)
    np.testing.assert_allclose(mass, LINK.m1 * np.eye(3), atol=1e-10)
    np.testing.assert_allclose(spring, LINK.k1 * incidence.T, atol=1e-8)
    np.testing.assert_allclose(cubic, LINK.k3 * incidence.T, atol=1e-7)
    np.testing.assert_allclose(damping, 0.3 * incidence.T @ incidence, atol=1e-9)


def test_the_true_matrices_move_as_the_true_chain(data):
    truth, start = ChainLink.true(LINK), np.random.default_rng(1).uniform(-0.3, 0.3, 6)
    samples = draw(truth, data.train, 0, 3, 0.0, np.random.default_rng(0))
    moved = follow(learn(samples), start, truth.mass)
    np.testing.assert_allclose(moved, simulate_chain(truth, start).states[-1], atol=1e-9)


def test_the_longer_the_chain_the_more_noise_costs(data):
    def error(links):
        noisy, clean = (
            learn(draw(ChainLink.true(LINK), data.train, 0, links, noise, np.random.default_rng(0)))
            for noise in (0.1, 0.0)
        )
        return np.linalg.norm(noisy - clean) / np.linalg.norm(clean)

    assert error(40) > 3 * error(2)


def test_with_fewer_samples_than_unknowns_the_motion_is_lost(data):
    found = {m.name: m.values for m in whole_chain_errors(data, [0, 1], LINK, 0.1, [2, 110])}
    assert set(found) == {f"whole_chain_{name}_{links}" for name in ("error", "seconds") for links in (2, 110)}
    assert found["whole_chain_error_110"].min() > 2 * found["whole_chain_error_2"].max()
    assert found["whole_chain_seconds_2"].min() > 0


def test_a_chain_that_makes_energy_is_infinitely_wrong(data):
    wrong = np.concatenate([np.eye(2), -50 * np.eye(2), -50 * np.eye(2), -5 * np.eye(2)])
    assert not np.isfinite(follow(wrong, np.full(4, 0.1), 0.5)).all()
