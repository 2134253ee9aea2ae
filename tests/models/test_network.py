"""The network: its start, its layout, and its expression."""

import math

import casadi
import numpy as np
import pytest
import torch
from tensors import assert_close

from repro.codegen.array_evaluation import evaluate
from repro.models.network import Network


def test_weights_start_glorot_uniform_and_biases_at_zero():
    network = Network(30, (40,), 20)
    weights = torch.from_numpy(network.initial([np.random.default_rng(k) for k in range(3)]))
    first, first_bias, last, last_bias = network.unpack(weights)
    assert first_bias.abs().max() == 0 and last_bias.abs().max() == 0
    for array, (n_in, n_out) in ((first, (30, 40)), (last, (40, 20))):
        limit = math.sqrt(6 / (n_in + n_out))
        assert 0.99 * limit < array.abs().max() <= limit
        assert array.var().item() == pytest.approx(limit**2 / 3, rel=0.05)
    assert not torch.equal(weights[0], weights[1])


def test_a_start_depends_on_its_own_generator_alone():
    network = Network(3, (4,), 1)
    pair = network.initial([np.random.default_rng(k) for k in (5, 6)])
    np.testing.assert_array_equal(network.initial([np.random.default_rng(6)]), pair[1:])


@pytest.mark.parametrize("skip", [False, True])
@pytest.mark.parametrize("activation", ["softplus", "tanh"])
def test_values_are_those_of_the_textbook(activation, skip):
    network = Network(3, (5, 4), 2, activation, skip)
    random = np.random.default_rng(0)
    weights, z = random.normal(size=(1, network.n_parameters)), random.normal(size=(1, 6, 3))
    arrays = [array[0].numpy() for array in network.unpack(torch.from_numpy(weights))]
    bend = np.tanh if activation == "tanh" else lambda x: np.log(1 + np.exp(x))
    hidden = bend(bend(z[0] @ arrays[0].T + arrays[1]) @ arrays[2].T + arrays[3])
    expected = hidden @ arrays[4].T + arrays[5] + (z[0] @ arrays[6].T if skip else 0)
    ours = network.propagate(torch.from_numpy(weights), torch.from_numpy(z[:, :, None]))
    np.testing.assert_allclose(ours[0, :, 0].numpy(), expected, rtol=1e-12)
    symbols = casadi.SX.sym("w", network.n_parameters), casadi.SX.sym("z", 3)
    function = casadi.Function("network", list(symbols), [network.expression(*symbols)])
    np.testing.assert_allclose(evaluate(function, weights, z[0]), expected, rtol=1e-12)


@pytest.mark.parametrize("value", [-800.0, -40.0, -1.0, 0.0, 1.0, 40.0, 800.0])
def test_softplus_and_its_derivatives_are_right_everywhere(value):
    """At 0 too, where every unit of a fresh network is at rest; and nothing overflows far out."""
    network = Network(1, (1,), 1)
    weights = np.array([[1.0, 0.0, 1.0, 0.0]])
    z, w = casadi.SX.sym("z"), casadi.DM(weights[0])
    expression = network.expression(casadi.SX(w), z)
    slope = casadi.gradient(expression, z)
    rows = [expression, slope, casadi.gradient(slope, z)]
    ours = evaluate(casadi.Function("f", [z], [casadi.densify(casadi.vertcat(*rows))]), np.array([value]))
    first = 1 / (1 + math.exp(-value)) if value > -700 else 0.0
    expected = [max(value, 0) + math.log1p(math.exp(-abs(value))), first, first * (1 - first)]
    np.testing.assert_allclose(ours, expected, atol=1e-15)
    jets = torch.tensor([[[[value], [1.0], [0.0]]]], dtype=torch.float64)
    theirs = network.propagate(torch.from_numpy(weights), jets, [(0, 0)])[0, 0, :, 0]
    np.testing.assert_allclose(theirs.numpy(), expected, atol=1e-15)


def test_parameters_are_counted_layer_by_layer():
    assert Network(4, (10,), 1).n_parameters == 4 * 10 + 10 + 10 + 1
    assert Network(2, (8,), 6, skip=True).n_parameters == 2 * 8 + 8 + 8 * 6 + 6 + 2 * 6


@pytest.mark.parametrize("activation", ["softplus", "tanh"])
def test_the_lie_gradient_is_every_pair_of_tangents_at_once(activation):
    network, random = Network(3, (5, 4), 1, activation), np.random.default_rng(0)
    weights = torch.from_numpy(random.normal(size=(2, network.n_parameters)))
    z, zdot = torch.from_numpy(random.normal(size=(2, 2, 6, 3)))
    units = torch.eye(3, dtype=z.dtype).expand(2, 6, 3, 3)
    jets = torch.cat([z.unsqueeze(2), zdot.unsqueeze(2), units, torch.zeros_like(units)], dim=2)
    pairs = network.propagate(weights, jets, [(0, 1), (0, 2), (0, 3)])[..., 0]
    value, rate, gradient, gradient_rate = network.lie_gradient(weights, z, zdot)
    for ours, expected in [(value, 0), (rate, 1), (gradient, slice(2, 5)), (gradient_rate, slice(5, 8))]:
        assert_close(ours, pairs[:, :, expected], rtol=1e-12, atol=1e-12)


def test_the_lie_gradient_is_that_of_one_output():
    z = torch.zeros(1, 1, 3, dtype=torch.float64)
    for network in (Network(3, (4,), 2), Network(3, (4,), 1, skip=True)):
        with pytest.raises(ValueError, match="one output"):
            network.lie_gradient(torch.zeros(1, network.n_parameters, dtype=torch.float64), z, z)
