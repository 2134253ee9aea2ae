"""`build` of every kind of model with the options of conf/model, and the two anchor rows."""

from dataclasses import replace
from pathlib import Path

import casadi
import numpy as np
import pytest
import torch
import yaml
from simulated import random_force

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.library.ensemble import build_model
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.bases import t1, t2
from repro.models.context import Context
from repro.models.kinds import lagrangian, structured, trivial
from repro.models.kinds.degenerate import Degenerate, Options, build
from repro.models.model_options import MODELS
from repro.plugins.checked import checked

CONF = Path(__file__).parents[2] / "conf" / "model"
SYSTEM = load("sip")
ELSEWHERE = {"lagrangian": "repro.models.lagrangian"}  # models whose class other kinds share


@pytest.fixture(scope="module")
def data():
    return random_force(SYSTEM, seeds=[0, 1, 2], samples=200, episode_steps=50)


@pytest.fixture
def context(data):
    return Context(t2, SYSTEM.coordinates, data.q, data.qd, data.train.qd, SYSTEM)


@pytest.mark.parametrize(
    "path",
    sorted(p for p in CONF.glob("*.yaml") if not yaml.safe_load(p.read_text()).get("parts")),
    ids=lambda p: p.stem,
)
def test_every_choice_of_conf_builds_and_predicts(path, data):
    options = yaml.safe_load(path.read_text())
    model = build_model(checked("model", MODELS, options), "t2", [data], SYSTEM)
    assert type(model).__module__ == ELSEWHERE.get(options["kind"], f"repro.models.kinds.{options['kind']}")
    weights = model.initial([np.random.default_rng(k) for k in range(3)])
    assert weights.shape == (3, model.n_parameters) and np.isfinite(weights).all()
    prepared = {name: torch.from_numpy(a) for name, a in model.prepare(data.q, data.qd, data.qdd, data.tau).items()}
    terms = model.evaluate(torch.from_numpy(weights), prepared, mass=True)
    assert (terms.tau if model.inverse else terms.acceleration).shape == data.tau.shape


@pytest.mark.parametrize("basis", ["raw", "engineered", "t1", "t2", "library"])
def test_every_basis_makes_a_lagrangian(basis, data):
    model = build_model(lagrangian.Options(hidden=(4,)), basis, [data], SYSTEM)
    assert model.n_parameters == model.initial([np.random.default_rng(0)]).shape[1]


def test_the_wide_start_keeps_units_within_their_quadratic_range(context):
    """The first layer is divided by 16 spreads of its inputs; nothing else changes."""
    plain, wide = (lagrangian.build(context, lagrangian.Options(initialisation=name)) for name in ("glorot", "wide"))
    first, second = (model.initial([np.random.default_rng(4)])[0] for model in (plain, wide))
    scale = np.concatenate([context.qd.reshape(-1, 2).std(0), [np.cos(context.q[..., 1]).std()]])
    np.testing.assert_allclose(second[:30].reshape(10, 3) * 16 * scale, first[:30].reshape(10, 3), rtol=1e-12)
    np.testing.assert_array_equal(second[30:], first[30:])
    inputs = np.stack([*np.moveaxis(context.qd, -1, 0), np.cos(context.q[..., 1])], axis=-1)
    assert np.abs(inputs @ second[:30].reshape(10, 3).T).max() < 1


@pytest.mark.parametrize(("start", "made_of"), [("ones", np.ones_like), ("positive", np.abs)])
def test_the_coefficients_of_a_linear_basis_start_as_chosen(context, start, made_of):
    linear = replace(context, basis=t1)
    plain, other = (lagrangian.build(linear, lagrangian.Options(initialisation=name)) for name in ("glorot", start))
    first, second = (model.initial([np.random.default_rng(4)])[0] for model in (plain, other))
    np.testing.assert_array_equal(second[plain.kinetic_slice], made_of(first[plain.kinetic_slice]))
    np.testing.assert_array_equal(second[plain.potential_slice], first[plain.potential_slice])


def test_a_structured_model_starts_with_the_inertia_scale_of_the_data(context):
    model = structured.build(context, structured.Options())
    weights = torch.from_numpy(model.initial([np.random.default_rng(k) for k in range(3)]))
    zero = np.zeros((3, 40, 2))
    q = np.random.default_rng(0).uniform(-3, 3, (3, 40, 2))
    prepared = {name: torch.from_numpy(a) for name, a in model.prepare(q, zero, zero, zero).items()}
    mass = model.evaluate(weights, prepared, mass=True).mass.numpy()
    scale = context.first_qd.reshape(-1, 2).std(0)
    np.testing.assert_allclose(mass * np.outer(scale, scale), np.broadcast_to(np.eye(2), mass.shape), atol=0.8)
    assert model.evaluate(weights, prepared).kinetic.abs().max() == 0  # T(q, 0) = 0 for any weights
    assert model.evaluate(weights, prepared).potential.abs().max() == 0


def test_scales_are_taken_where_training_starts_and_never_zero(data):
    still = np.zeros_like(data.qd)
    np.testing.assert_array_equal(
        Context(t2, SYSTEM.coordinates, data.q, data.qd, still, SYSTEM).velocity_scale, [1, 1]
    )
    np.testing.assert_array_equal(
        Context(t2, SYSTEM.coordinates, 0 * data.q, still, data.qd, SYSTEM).feature_scale, [1, 1, 1]
    )
    expected = data.qd[:, :50].reshape(-1, 2).std(0)
    np.testing.assert_allclose(
        Context(t2, SYSTEM.coordinates, data.q, data.qd, data.qd[:, :50], SYSTEM).velocity_scale, expected
    )


def test_the_trivial_model_says_nothing(context, data):
    model = trivial.build(context, trivial.Options())
    assert model.n_parameters == 0 and model.initial([np.random.default_rng(0)] * 2).shape == (2, 0)
    prepared = {name: torch.from_numpy(a) for name, a in model.prepare(data.q, data.qd, data.qdd, data.tau).items()}
    terms = model.evaluate(torch.zeros(3, 0), prepared)
    for quantity in (terms.tau, terms.acceleration, terms.momentum, terms.lagrangian, terms.energy_sum):
        assert quantity.abs().max() == 0


@pytest.mark.parametrize("name", ["sip", "sip_rod"])
def test_the_degenerate_model_is_the_cart_momentum_alone(name, data):
    """T = p_x^2 / 2 m with the true p_x; its momentum is (p_x, p_x dp_x/dthetad / m); its mass matrix has rank one."""
    system = load(name)
    model = Degenerate(system)
    prepared = {name: torch.from_numpy(a) for name, a in model.prepare(data.q, data.qd, data.qdd, data.tau).items()}
    terms = model.evaluate(torch.zeros(3, 0, dtype=torch.float64), prepared)
    p = evaluate(dynamics_of(system).momentum, data.q, data.qd)[..., 0]
    coupling = system.m1 * system.links[0].centre * np.cos(data.q[..., 1]) / (system.m0 + system.m1)
    np.testing.assert_allclose(terms.kinetic, p**2 / 2 / 0.8, atol=1e-14)
    np.testing.assert_allclose(terms.momentum, np.stack([p, p * coupling], axis=-1), atol=1e-13)
    np.testing.assert_allclose(
        terms.hamiltonian(torch.from_numpy(data.qd)), terms.kinetic, atol=1e-13
    )  # quadratic, no gravity
    q, qd = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2)
    mass = casadi.hessian(model.energies(q, qd, casadi.SX(0, 1)).kinetic, qd)[0]
    determinant = casadi.Function("det", [q, qd], [casadi.densify(casadi.det(mass))])
    np.testing.assert_allclose(evaluate(determinant, data.q, data.qd), 0, atol=1e-16)


def test_the_degenerate_model_needs_the_true_system(data):
    with pytest.raises(UserError, match="data=file"):
        build(Context(t2, SYSTEM.coordinates, data.q, data.qd, data.qd, None), Options())
