"""Anyone's module as a model: torch.func, the traced expressions and finite differences agree."""

import casadi
import numpy as np
import pytest
import torch
from torch import nn

from repro.errors import UserError
from repro.models.module_model import Form, ModuleModel, form_of


class Lagrangian(nn.Module):
    def __init__(self):
        super().__init__()
        self.net = nn.Sequential(nn.Linear(6, 5), nn.Softplus(), nn.Linear(5, 1))

    def forward(self, q, qd):
        return self.net(torch.cat([torch.cos(q), torch.sin(q), qd], dim=-1)).squeeze(-1) + (qd**2).sum(-1)


class Energies(nn.Module):
    def __init__(self):
        super().__init__()
        self.height, self.inertia = nn.Parameter(torch.randn(2)), nn.Linear(2, 2)

    def forward(self, q, qd):
        scale = torch.exp(self.inertia(torch.cos(q)))
        return (scale * qd.square()).sum() / 2, torch.dot(self.height, torch.sin(q))


class Port(nn.Module):
    def __init__(self):
        super().__init__()
        self.factor, self.height = nn.Linear(2, 4), nn.Linear(2, 1)
        self.friction = nn.Parameter(torch.randn(2))

    def mass(self, q):
        factor = self.factor(torch.cos(q)).reshape(2, 2)
        return factor @ factor.transpose(-1, -2) + torch.eye(2, dtype=q.dtype)

    def potential(self, q):
        return self.height(torch.tanh(q))

    def dissipation(self, q):
        return torch.diag(self.friction**2)


class Acceleration(nn.Module):
    def __init__(self):
        super().__init__()
        self.net = nn.Sequential(nn.Linear(6, 5), nn.Tanh(), nn.Linear(5, 2))

    def forward(self, q, qd, tau):
        return self.net(torch.cat([q, qd, tau], dim=-1))


class Opaque(Lagrangian):
    def forward(self, q, qd):
        return super().forward(q, torch.erfc(qd)) + (qd**2).sum(-1)


FORMS = {Lagrangian: Form.LAGRANGIAN, Energies: Form.ENERGIES, Port: Form.PORT, Acceleration: Form.ACCELERATION}


def _samples(seed, members=2, samples=4):
    draws = np.random.default_rng(seed).normal(size=(4, members, samples, 2))
    return list(draws)


def _prepared(model, samples):
    return {name: torch.from_numpy(array) for name, array in model.prepare(*samples).items()}


@pytest.fixture(params=FORMS, ids=lambda factory: factory.__name__)
def model(request):
    return ModuleModel(request.param, 2)


def _weights(model, members=2):
    return torch.from_numpy(model.initial([np.random.default_rng(seed) for seed in range(members)]))


def _predicted(model, terms):
    return terms.tau if model.energetic else terms.acceleration


def test_the_form_is_read_off_the_module(model):
    assert model.form == FORMS[model.factory]
    assert model.not_symbolic is None


def test_expressions_equal_torch(model):
    q, qd, qdd, tau = samples = _samples(0)
    weights = _weights(model)
    terms = model.evaluate(weights, _prepared(model, samples), mass=True)
    symbols = [casadi.SX.sym(name, 2) for name in ("q", "qd", "qdd", "tau")]
    parameters = casadi.SX.sym("parameters", model.n_parameters)
    if model.energetic:
        energies = model.energies(*symbols[:2], parameters)
        ours = [
            model.inverse_dynamics(*symbols[:3], parameters), model.momentum(*symbols[:2], parameters),
            energies.kinetic, energies.potential,
        ]  # fmt: skip
        theirs = [terms.tau, terms.momentum, terms.kinetic[..., None], terms.potential[..., None]]
    else:
        ours, theirs = [model.acceleration(symbols[0], symbols[1], symbols[3], parameters)], [terms.acceleration]
    function = casadi.Function("f", [*symbols, parameters], ours)
    for member in range(2):
        for sample in range(4):
            values = function.call([*(array[member, sample] for array in (q, qd, qdd, tau)), weights[member].numpy()])
            for value, expected in zip(values, theirs, strict=True):
                np.testing.assert_allclose(value.full().ravel(), expected[member, sample].numpy(), atol=1e-12)


def test_gradients_of_rows_agree_with_finite_differences(model):
    weights, prepared = _weights(model), _prepared(model, _samples(1))
    _, jacobian = model.rows(weights, prepared, lambda terms: _predicted(model, terms), mass=True)
    direction = torch.from_numpy(np.random.default_rng(3).normal(size=model.n_parameters))
    ahead, behind = (_predicted(model, model.evaluate(weights + s * 1e-6 * direction, prepared)) for s in (1, -1))
    slope = (ahead - behind) / 2e-6
    assert torch.allclose(torch.einsum("mrnp,p->mnr", jacobian, direction), slope, atol=1e-7)


def test_a_port_module_loses_exactly_its_friction():
    model = ModuleModel(Port, 2)
    weights = _weights(model)
    q, qd, _, _ = _samples(2)
    zero = np.zeros_like(q)
    without = ModuleModel(Port, 2)
    with torch.no_grad():
        moving = model.evaluate(weights, _prepared(model, (q, qd, zero, zero)))
    names = list(without.shapes)
    frictionless = weights.clone()
    frictionless[:, without.places["friction"]] = 0.0
    still = without.evaluate(frictionless, _prepared(without, (q, qd, zero, zero)))
    coefficients = weights[:, without.places["friction"]].square()
    assert "friction" in names
    assert torch.allclose(moving.tau - still.tau, coefficients[:, None] * torch.from_numpy(qd))


def test_an_operation_without_symbol_is_named_and_the_rest_works():
    model = ModuleModel(Opaque, 2)
    assert model.not_symbolic == "erfc has no symbolic form"
    terms = model.evaluate(_weights(model), _prepared(model, _samples(0)), mass=True)
    assert torch.isfinite(terms.tau).all()


def test_starts_follow_the_seeds_alone():
    model = ModuleModel(Lagrangian, 2)
    torch.manual_seed(5)
    first = model.initial([np.random.default_rng(1)])
    torch.rand(3)
    assert np.array_equal(first, model.initial([np.random.default_rng(1)]))


class Wrong(nn.Module):
    def forward(self, q, qd):
        return torch.cat([q, qd])


def test_a_module_of_no_form_is_refused_in_one_line():
    with pytest.raises(UserError, match=r"Wrong is none of L = module\(q, qd\).*shape \(4,\)") as error:
        form_of(Wrong().double(), 2)
    assert "\n" not in str(error.value)
