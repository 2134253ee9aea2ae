"""Inverse and forward dynamics without a Hessian, against the definition with one."""

import itertools

import casadi
import numpy as np
import pytest
import torch
from tensors import assert_close
from torch.func import grad, hessian, vmap

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.bases import engineered, raw
from repro.models.euler_lagrange import forward_dynamics, inverse_dynamics, mass_matrix
from repro.models.lagrangian import Lagrangian

# torch loads its rules for forward mode with a function that torch itself deprecates
pytestmark = pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning")

SAMPLES = 9


def motion(n_q, seed=0):
    return [torch.from_numpy(array) for array in np.random.default_rng(seed).normal(size=(4, SAMPLES, n_q))]


def network(n_q, hidden=(6, 5), seed=0):
    """L(q, qd) of a random network, with a mass matrix that is not singular, and its weights."""
    sizes, generator = (2 * n_q, *hidden, 1), np.random.default_rng(seed)
    shapes = [shape for pair in itertools.pairwise(sizes) for shape in (pair, pair[1:])]
    weights = [torch.from_numpy(0.5 * generator.normal(size=shape)).requires_grad_() for shape in shapes]

    def lagrangian(q, qd):
        output = torch.cat([q, qd], dim=-1)
        for weight, bias in zip(weights[:-2:2], weights[1:-2:2], strict=True):
            output = torch.nn.functional.softplus(output @ weight + bias)
        return (output @ weights[-2] + weights[-1]).squeeze(-1) + qd.square().sum(-1)

    return lagrangian, weights


def naive(lagrangian, q, qd, qdd):
    """tau and M of one sample after another, by the definition."""
    n_q = q.shape[-1]

    def one(q, qd, qdd):
        def of_state(x):
            return lagrangian(x[:n_q], x[n_q:])

        x = torch.cat([q, qd])
        curvature, slope = hessian(of_state)(x), grad(of_state)(x)
        mass = curvature[n_q:, n_q:]
        return mass @ qdd + curvature[n_q:, :n_q] @ qd - slope[:n_q], mass

    return vmap(one)(q, qd, qdd)


def gradients(value, weights):
    return torch.autograd.grad(value.square().sum(), weights, allow_unused=True, materialize_grads=True)


@pytest.mark.parametrize("n_q", range(1, 9))
def test_inverse_dynamics_and_their_gradients_agree_with_the_hessian(n_q):
    lagrangian, weights = network(n_q)
    q, qd, qdd, _ = motion(n_q)
    ours, (expected, _) = inverse_dynamics(lagrangian, q, qd, qdd), naive(lagrangian, q, qd, qdd)
    assert_close(ours, expected, rtol=1e-10, atol=1e-10)
    for one, other in zip(gradients(ours, weights), gradients(expected, weights), strict=True):
        assert_close(one, other, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("n_q", range(1, 9))
def test_forward_dynamics_and_their_gradients_agree_with_the_hessian(n_q):
    lagrangian, weights = network(n_q)
    q, qd, _, tau = motion(n_q)
    rest, mass = naive(lagrangian, q, qd, torch.zeros_like(qd))
    expected = torch.linalg.solve(mass, tau - rest)
    ours = forward_dynamics(lagrangian, q, qd, tau)
    assert_close(mass_matrix(lagrangian, q, qd), mass, rtol=1e-10, atol=1e-10)
    assert_close(ours, expected, rtol=1e-9, atol=1e-9)
    for one, other in zip(gradients(ours, weights), gradients(expected, weights), strict=True):
        assert_close(one, other, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("links", [1, 3])
def test_the_true_pendulum_is_recovered_from_its_lagrangian(links):
    system = load("cart_rods", n=links)
    q, qd, qdd, _ = motion(system.n_q)
    dynamics = dynamics_of(system)

    def lagrangian(q, qd):
        return system.kinetic(q.unbind(-1), qd.unbind(-1), torch) - system.potential(q.unbind(-1), torch)

    ours = inverse_dynamics(lagrangian, q, qd, qdd).detach().numpy()
    expected = evaluate(dynamics.inverse, q.numpy(), qd.numpy(), qdd.numpy())
    np.testing.assert_allclose(ours, expected, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("basis", [raw, engineered])
@pytest.mark.parametrize("n_q", range(1, 9))
def test_networks_of_features_agree_with_the_definition_in_symbols(basis, n_q):
    model = Lagrangian(basis, n_q, hidden=(5, 4))
    parameters = torch.from_numpy(model.initial([np.random.default_rng(0), np.random.default_rng(1)]))
    samples = np.random.default_rng(2).normal(size=(4, 2, SAMPLES, n_q))
    prepared = {name: torch.from_numpy(array) for name, array in model.prepare(*samples).items()}
    ours = model.evaluate(parameters, prepared).tau.numpy()
    q, qd, qdd, theta = (
        casadi.SX.sym(x, n) for x, n in [("q", n_q), ("v", n_q), ("a", n_q), ("w", len(parameters[0]))]
    )
    tau = casadi.Function("tau", [q, qd, qdd, theta], [model.inverse_dynamics(q, qd, qdd, theta)])
    weights = np.repeat(parameters.numpy()[:, None], SAMPLES, axis=1)
    np.testing.assert_allclose(ours, evaluate(tau, *samples[:3], weights), rtol=1e-10, atol=1e-10)
