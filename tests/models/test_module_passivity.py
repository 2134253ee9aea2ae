"""The port form and the passivity of torch modules: by torch.func as by expressions."""

import numpy as np
import pytest
import torch
from torch import nn

from repro.mechanics.coordinate import Coordinate
from repro.mechanics.system import load
from repro.models.module_model import ModuleModel
from repro.models.passivity_margin import States, margins

COORDINATES = (Coordinate("x", "m", False), Coordinate("theta", "rad", True))


class Ports(nn.Module):
    """A port-Hamiltonian system with a friction of either sign."""

    def __init__(self, friction):
        super().__init__()
        self.net, self.factor = nn.Linear(2, 1), nn.Parameter(friction * torch.tensor([1.0, 0.5]))

    def mass(self, q):
        return torch.stack(
            [torch.stack([2.0 + 0 * q[0], torch.cos(q[1])]), torch.stack([torch.cos(q[1]), 1 + q[1] ** 2])]
        )

    def potential(self, q):
        return self.net(torch.stack([torch.cos(q[1]), torch.sin(q[1])]))

    def dissipation(self, q):
        return torch.diag(self.factor)


class Gyroscopic(nn.Module):
    """L with a term linear in the velocities."""

    def __init__(self):
        super().__init__()
        self.net = nn.Linear(2, 1)

    def forward(self, q, qd):
        return 0.5 * (qd**2).sum(-1) + qd[..., 0] * torch.sin(q[..., 1]) - self.net(torch.cos(q))


@pytest.fixture
def states():
    return States.random(COORDINATES, np.array([1.0, 2.0]), 50, np.random.default_rng(1))


def opaque(factory):
    """The same module, whose expressions are not used."""
    model = ModuleModel(factory, 2)
    assert model.not_symbolic is None
    model.not_symbolic = "for this test"
    return model


@pytest.mark.parametrize("factory", [lambda: Ports(1.0), Gyroscopic], ids=["port", "lagrangian"])
def test_both_ways_agree(factory, states):
    symbolic, numeric = ModuleModel(factory, 2), opaque(factory)
    (weights,) = symbolic.initial([np.random.default_rng(2)])
    for ours, expected in zip(
        numeric.port_values(weights, states.q, states.qd),
        symbolic.port_values(weights, states.q, states.qd),
        strict=True,
    ):
        np.testing.assert_allclose(ours, expected, atol=1e-12)
    sip = load("sip")
    for storage in (None, sip):
        ours, expected = (margins(model, weights, states, storage) for model in (numeric, symbolic))
        np.testing.assert_allclose(ours, expected, atol=1e-9)


@pytest.mark.parametrize(("friction", "passive"), [(1.0, True), (-1.0, False)])
def test_negative_friction_is_not_passive(friction, passive, states):
    model = opaque(lambda: Ports(friction))
    (weights,) = model.initial([np.random.default_rng(2)])
    assert (margins(model, weights, states).max() <= 1e-12) == passive
