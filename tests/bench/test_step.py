"""Whatever is timed against each other computes the same numbers."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from optional import needs_compiler

from repro.bench.framework_peers import torch_compiled_step
from repro.bench.naive import engineered_features, naive_step, t2_features
from repro.bench.training_case import TrainingCase, native_step, network, pendulum_case, torch_step, triangular
from repro.errors import UserError
from repro.models.bases import engineered, t2
from repro.models.lagrangian import Lagrangian

# torch.func loads its rules for forward mode with a function that torch itself deprecates
pytestmark = [
    pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated:DeprecationWarning"),
    pytest.mark.usefixtures("unoptimised"),
]


def agree(first, second):
    for one, two in zip(first(), second(), strict=True):
        assert one.shape == two.shape
        assert np.abs(two).max() > 0
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-9 * np.abs(two).max())


@pytest.mark.parametrize("equation", ["inverse", "forward"])
@pytest.mark.parametrize("hidden", [(10,), (6, 5)])
def test_jets_agree_with_the_hessian(hidden, equation):
    case = pendulum_case(network(t2, hidden), 2, 40)
    agree(torch_step(case, equation), naive_step(case, equation, t2_features))


@needs_compiler
@pytest.mark.parametrize("equation", ["inverse", "forward"])
def test_generated_code_agrees_with_the_hessian(equation):
    case = pendulum_case(network(t2, (10,)), 2, 40)
    agree(native_step(case, equation), naive_step(case, equation, t2_features))


@needs_compiler
def test_engines_agree_on_the_triangular_factor():
    case = pendulum_case(triangular((5,)), 1, 40)
    agree(native_step(case, "inverse"), torch_step(case, "inverse"))


def test_jets_agree_with_one_network_of_engineered_features():
    case = pendulum_case(network(engineered, (7, 4)), 1, 40)
    agree(torch_step(case, "inverse"), naive_step(case, "inverse", engineered_features))


def test_the_gradient_is_that_of_the_loss():
    case = pendulum_case(network(t2, (4,)), 1, 30)
    gradient = naive_step(case, "inverse", t2_features)()[1]
    direction = np.random.default_rng(0).normal(size=gradient.shape)

    def loss(length):
        moved = replace(case, parameters=case.parameters + torch.from_numpy(length * direction))
        return naive_step(moved, "inverse", t2_features)()[0]

    difference = (loss(1e-5) - loss(-1e-5)) / 2e-5
    np.testing.assert_allclose(difference, (gradient * direction).sum(1), rtol=1e-6)


def test_each_member_has_its_own_data_and_weights():
    case = pendulum_case(network(t2, (4,)), 2, 30)
    losses, _ = torch_step(case, "inverse")()
    assert losses[0] != losses[1]


@needs_compiler
def test_a_wide_network_agrees_with_the_hessian_in_compiled_code():
    case = pendulum_case(network(t2, (40, 23)), 1, 50)
    agree(native_step(case, "inverse"), naive_step(case, "inverse", t2_features))


@needs_compiler
@pytest.mark.parametrize("equation", ["inverse", "forward"])
def test_a_wide_triangular_factor_agrees_with_torch_in_compiled_code(equation):
    case = pendulum_case(triangular((40, 23)), 2, 50)
    agree(native_step(case, equation), torch_step(case, equation))


def test_a_large_network_with_a_momentum_of_its_own_has_no_compiled_code():
    case = pendulum_case(network(t2, (4,)), 1, 10)
    model = Lagrangian(t2, 2, hidden=(150,), momentum_hidden=(2,))
    weights = torch.from_numpy(model.initial([np.random.default_rng(0)]))
    with pytest.raises(UserError, match="no compiled code"):
        native_step(TrainingCase(model, weights, case.dataset), "inverse")


@needs_compiler
def test_single_precision_comes_close():
    case = pendulum_case(network(t2, (6, 5)), 2, 40)
    for ours, other in zip(native_step(case, "inverse", "float32")(), native_step(case, "inverse")(), strict=True):
        np.testing.assert_allclose(ours, other, rtol=0, atol=1e-5 * np.abs(other).max())


@needs_compiler
def test_the_batched_form_agrees_before_it_is_compiled(monkeypatch):
    monkeypatch.setattr(torch, "compile", lambda function: function)
    case = pendulum_case(network(t2, (6, 5)), 1, 40)
    agree(native_step(case, "inverse"), torch_compiled_step(case, "float64"))
