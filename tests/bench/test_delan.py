"""The deep Lagrangian network is the Euler-Lagrange equation of its own kinetic energy, plus its force."""

import numpy as np
import pytest
import torch
from tensors import assert_close
from torch.func import grad, hessian, jacrev, vmap

from repro.bench.delan import DeLaN, delan_step
from repro.bench.training_case import triangular_case

# torch.func loads its rules for forward mode with a function that torch itself deprecates
pytestmark = pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning")

N_Q = 3


@pytest.fixture
def peer():
    return DeLaN(N_Q, (7, 5))


@pytest.fixture
def weights(peer):
    generator = np.random.default_rng(3)
    return torch.from_numpy(
        peer.network.initial([generator])[0] + 0.2 * generator.normal(size=peer.network.n_parameters)
    )


@pytest.fixture
def motion():
    return [torch.from_numpy(array) for array in np.random.default_rng(4).normal(size=(3, 20, N_Q))]


def test_inverse_is_the_autodiff_of_its_own_energy(peer, weights, motion):
    def tau(q, qd, qdd):
        def kinetic(x):
            factor, _, _ = peer.heads(weights, x[None, :N_Q])
            return 0.5 * (factor[0].T @ x[N_Q:]).square().sum()

        x = torch.cat([q, qd])
        curvature, slope = hessian(kinetic)(x), grad(kinetic)(x)
        force = peer.heads(weights, q.unsqueeze(0))[2][0]
        return curvature[N_Q:, N_Q:] @ qdd + curvature[N_Q:, :N_Q] @ qd - slope[:N_Q] + force

    assert_close(peer.inverse(weights, *motion), vmap(tau)(*motion), rtol=1e-10, atol=1e-10)


def test_both_ways_of_differentiating_give_one_force(peer, weights, motion):
    assert_close(peer.automatic_inverse(weights, *motion), peer.inverse(weights, *motion))


def test_slopes_are_the_derivatives_of_the_factor(peer, weights, motion):
    def factor(q):
        return peer.heads(weights, q.unsqueeze(0))[0][0]

    assert_close(peer.heads(weights, motion[0])[1], vmap(jacrev(factor))(motion[0]))


def test_the_factor_is_triangular_with_a_positive_diagonal(peer, weights, motion):
    factor, _, _ = peer.heads(weights, motion[0])
    assert torch.equal(factor, factor.tril())
    assert factor.diagonal(dim1=1, dim2=2).min() > 0
    assert (factor.tril(-1) != 0).any()


def test_the_step_is_the_mean_squared_error_of_tau():
    case = triangular_case((5,), 1, 30)
    loss, gradient = delan_step(case, (5,))()
    peer = DeLaN(2, (5,))
    start = torch.from_numpy(peer.network.initial([np.random.default_rng([0, 1])])[0])
    data = case.dataset
    error = peer.inverse(start, *(torch.from_numpy(a[0]) for a in (data.q, data.qd, data.qdd))).numpy() - data.tau[0]
    assert loss == pytest.approx([(error**2).sum(1).mean()])
    assert gradient.shape == (1, peer.network.n_parameters)
