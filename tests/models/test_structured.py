"""The structured model: M is positive semi-definite whatever the weights, and the truth is in its class."""

from types import SimpleNamespace

import casadi
import numpy as np
import pytest
import torch
from simulated import random_force
from tensors import assert_close

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import derive
from repro.mechanics.system import load
from repro.models.bases import t2
from repro.models.context import Context
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured

SYSTEMS = {
    "one link": lambda: load("sip_rod"),
    "two links": lambda: load("dip"),
    "three links": lambda: load("cart_rods", n=3),
}
KINDS = {
    "wide": {"hidden": (8,)},
    "deep": {"hidden": (4, 4), "skip": False, "activation": "softplus"},
    "square": {"hidden": (5,), "rank": 3},
    "triangular": {"hidden": (5,), "factor": "triangular"},
    "triangular from Glorot's weights": {"hidden": (5,), "factor": "triangular", "initialisation": "glorot"},
}


@pytest.fixture(params=KINDS)
def model(request):
    return Structured(3, np.array([0.9, 5.0, 9.0]), structured.Options(**KINDS[request.param]))


@pytest.fixture(scope="module")
def samples():
    random = np.random.default_rng(3)
    scales = {"q": 2.0, "qd": 3.0, "qdd": 20.0, "tau": 1.0}
    return {name: scale * random.normal(size=(2, 40, 3)) for name, scale in scales.items()}


def _prepared(model, samples):
    return {name: torch.from_numpy(array) for name, array in model.prepare(**samples).items()}


def _random(model):
    weights = model.initial([np.random.default_rng(seed) for seed in (0, 1)])
    return torch.from_numpy(weights + np.random.default_rng(2).normal(size=weights.shape))


def test_the_mass_matrix_is_symmetric_and_positive_semi_definite(model, samples):
    terms = model.evaluate(_random(model), _prepared(model, samples), mass=True)
    assert torch.equal(terms.mass, terms.mass.mT)
    eigenvalues = torch.linalg.eigvalsh(terms.mass)
    assert torch.all(eigenvalues[..., 0] >= -1e-14 * eigenvalues[..., -1])
    assert torch.all(terms.kinetic >= 0)


def test_the_engine_agrees_with_the_lagrangian_differentiated_by_casadi(model, samples):
    weights = _random(model)
    terms = model.evaluate(weights, _prepared(model, samples), mass=True)
    q, qd, theta = casadi.SX.sym("q", 3), casadi.SX.sym("qd", 3), casadi.SX.sym("theta", model.n_parameters)
    energies = model.energies(q, qd, theta)
    dynamics = derive(energies.kinetic, energies.potential, casadi.SX(0), q, qd, theta)
    each = np.repeat(weights.numpy()[:, None], 40, axis=1)
    motion = (samples["q"], samples["qd"], samples["qdd"])
    np.testing.assert_allclose(terms.tau, evaluate(dynamics.inverse, *motion, each), rtol=1e-9, atol=1e-9)
    mass = evaluate(dynamics.mass_matrix, *motion[:2], each).reshape(terms.mass.shape)
    np.testing.assert_allclose(terms.mass, mass, rtol=1e-9, atol=1e-9)


def test_the_jacobian_is_that_of_autograd(model, samples):
    few = {name: values[:, :5] for name, values in samples.items()}  # autograd takes one pass per row
    weights, prepared = _random(model), _prepared(model, few)
    _, jacobian = model.rows(weights, prepared, lambda terms: terms.tau, mass=False)
    expected = torch.autograd.functional.jacobian(
        lambda one: model.evaluate(one.unsqueeze(0), {k: v[:1] for k, v in prepared.items()}).tau[0], weights[0]
    )
    assert_close(jacobian[0].transpose(0, 1), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_true_system_is_in_the_class(name):
    """C has a column a velocity of a centre of mass, and one a rotation: linear in cosines and sines."""
    system = SYSTEMS[name]()
    data = random_force(system, seeds=[0], samples=300, episode_steps=50, reset="random")
    model, weights = _true_model(system)
    prepared = _prepared(model, {name: getattr(data, name) for name in ("q", "qd", "qdd", "tau")})
    terms = model.evaluate(torch.from_numpy(weights[None]), prepared, mass=True)
    np.testing.assert_allclose(terms.tau, data.tau, atol=1e-10)


def test_without_scaling_the_start_is_one_unit_of_inertia_a_coordinate():
    random = np.random.default_rng(0)
    qd = random.normal(size=(1, 50, 3)) * [1.0, 5.0, 9.0]
    context = Context(t2, load("dip").coordinates, qd, qd, qd, None)
    scaled, plain = (
        structured.build(context, structured.Options(hidden=(4,), scaled=scaled)) for scaled in (True, False)
    )
    np.testing.assert_array_equal(plain.velocity_scale, 1)
    np.testing.assert_allclose(scaled.velocity_scale, qd[0].std(0))


def _true_model(system):
    n, links = system.n_q - 1, system.links
    scale = np.linspace(0.5, 2.0, n + 1)
    model = Structured(n + 1, scale, structured.Options(hidden=(2,), rank=1 + 3 * n))
    factor = SimpleNamespace(
        constant=np.zeros((n + 1, 1 + 3 * n)), cos=np.zeros((n + 1, 1 + 3 * n, n)), sin=np.zeros((n + 1, 1 + 3 * n, n))
    )
    factor.constant[0, 0] = system.m0**0.5
    for i, link in enumerate(links):
        x, y, turn = 1 + 3 * i, 2 + 3 * i, 3 + 3 * i
        factor.constant[0, x] = link.mass**0.5
        factor.constant[1 + i, turn] = link.inertia**0.5
        for j in range(i + 1):
            arm = link.mass**0.5 * (link.centre if j == i else links[j].length)
            factor.cos[1 + j, x, j] = factor.sin[1 + j, y, j] = arm
    factor.constant *= scale[:, None]
    inputs = np.concatenate([factor.cos, factor.sin], axis=-1) * scale[:, None, None]
    arrays = [np.zeros(shape) for shape in model.network.shapes]
    arrays[3], arrays[4] = factor.constant.ravel(), inputs.reshape(-1, 2 * n)
    gravity = [system.up * system.g * sum(_moment(links, i, j) for i in range(n)) for j in range(n)]
    return model, np.concatenate([*(array.ravel() for array in arrays), gravity])


def _moment(links, i, j):
    return 0.0 if j > i else links[i].mass * (links[i].centre if j == i else links[j].length)
