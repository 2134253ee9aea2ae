"""Chains of a learned link: exact where the link is, at a cost that does not explode."""

import numpy as np
import pytest
import torch

from repro.evaluation.chains import chain_errors, random_start, simulate_chain
from repro.mechanics.system import load
from repro.models.bases import spring
from repro.models.damped import Damped
from repro.models.lagrangian import Lagrangian
from repro.models.ports import ChainLink

LINK = load("link", damping=[0.3])
MODEL = Damped(Lagrangian(spring, 1), "diagonal")
TRUE = [0.25, 10.0, 10.0, 0.3]


def test_a_true_link_makes_the_true_chain_and_a_wrong_one_does_not():
    weights = torch.tensor([TRUE, [0.25, 10.1, 10.0, 0.3]], dtype=torch.float64)
    found = {metric.name: metric.values for metric in chain_errors(MODEL, weights, LINK, [3, 30])}
    assert {name.rpartition("_")[2] for name in found} == {"3", "30"}
    for links in (3, 30):
        assert found[f"chain_error_{links}"][0] < 1e-12
        assert 1e-3 < found[f"chain_error_{links}"][1] < 1
        assert found[f"chain_seconds_{links}"].min() > 0


def test_the_energy_of_a_chain_only_falls():
    motion = simulate_chain(ChainLink.true(LINK), random_start(10))
    assert np.diff(motion.energy).max() < 0
    assert motion.energy[0] > 2 * motion.energy[-1]


def test_an_undamped_chain_keeps_its_energy():
    motion = simulate_chain(ChainLink.true(load("link")), random_start(10))
    assert np.ptp(motion.energy) < 1e-5 * motion.energy[0]


def test_one_link_is_the_system_itself():
    from repro.mechanics.derive import dynamics_of
    from repro.mechanics.simulate import simulate

    start = random_start(1)
    motion = simulate_chain(ChainLink.true(LINK), start)
    state = np.array([[start[0], start[1] / 0.5]])
    alone = simulate(dynamics_of(LINK).acceleration, state, np.zeros((1, 100, 1)), 0.1)[0]
    np.testing.assert_allclose(motion.states * [1, 2], alone, atol=1e-6)


def test_a_rate_is_kept_every_so_often():
    motion = simulate_chain(ChainLink.true(LINK), random_start(2))
    assert motion.states.shape == (101, 4)
    assert motion.energy.shape == (101,)
    assert motion.energy[0] == pytest.approx(
        sum(LINK.potential([s], np) for s in motion.states[0, :2]) + (motion.states[0, 2:] ** 2).sum() / (2 * 0.5)
    )
