"""Eq. (12): two port-Hamiltonian sub-systems and a learned J_I, R_I are the damped double pendulum, and passive."""

from dataclasses import replace

import casadi
import numpy as np
import pytest
import torch
from simulated import random_force

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.evaluation.pointwise import pointwise
from repro.learning.objective import Objective
from repro.learning.objectives import port
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.learning.watch import PassivityWatch
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.bases import fxf, rigid_body, t1
from repro.models.context import Context, SubModel
from repro.models.damped import Damped
from repro.models.gauge import Gauge
from repro.models.kinds.port_hamiltonian import Options, build
from repro.models.lagrangian import Lagrangian
from repro.models.passivity_margin import States, worst_margin

DAMPED = load("dip", damping=[0.3, 0.01, 0.005])
# of sip_rod and of the second rod: halves of masses and inertias, first moments, weights
CART, ROD = [0.4, 0.2 * 0.25 / 6, 0.05, 0.49], [0.1, 0.2 * 0.25 / 24, 1.96]
HINGED = Options(energy="hinged", dissipation="constant", hidden=(3,), damping_hidden=(2,), floor=0.0)


@pytest.fixture(scope="module")
def data():
    return random_force(DAMPED, seeds=[0, 1], samples=300, episode_steps=50, reset="random")


def _context(data, *parts):
    trained = tuple(SubModel(model, np.array([weights])) for model, weights in parts)
    return Context(fxf, DAMPED.coordinates, data.q, data.qd, data.train.qd, DAMPED, trained)


def _true_parts(data):
    """The true bodies with the friction of the cart and of the first joint, and J_I, R_I with that of the hinge."""
    cart = (Damped(Lagrangian(t1, 2), "diagonal"), [*CART, 0.3, 0.01])
    model = build(_context(data, cart, (Lagrangian(rigid_body, 3), ROD)), HINGED)
    weights = model.initial([np.random.default_rng(0)])
    # C = D L L' D of the hinge, 0.005 (thetad2 - thetad1)^2, D = diag(1 / scale)
    _, first, second = np.sqrt(0.005) * model.velocity_scale
    below, diagonal = [0.0, 0.0, -second], np.log(np.expm1([1e-9, first, 1e-9]))
    weights[:, model.damping_slice] = [*below, *diagonal]
    return model, weights


def _accelerations(model, weights, q, qd, tau):
    symbols = [casadi.SX.sym(name, 3) for name in ("q", "qd", "tau")]
    parameters = casadi.SX.sym("parameters", model.n_parameters)
    qdd = model.acceleration(*symbols, parameters)
    return evaluate(casadi.Function("qdd", [*symbols, parameters], [casadi.densify(qdd)]), q, qd, tau, weights)


def test_true_sub_systems_and_the_friction_of_the_hinge_are_the_damped_double_pendulum(data):
    model, weights = _true_parts(data)
    q, qd, tau = data.q[0], data.qd[0], data.tau[0]
    expected = evaluate(dynamics_of(DAMPED).acceleration, q, qd, tau)
    np.testing.assert_allclose(_accelerations(model, weights[0], q, qd, tau), expected, rtol=1e-6, atol=1e-6)


def test_the_energy_of_the_first_sub_system_is_judged_by_that_of_the_true_one(data):
    model, weights = _true_parts(data)
    one = replace(data, q=data.q[:1], qd=data.qd[:1], qdd=data.qdd[:1], tau=data.tau[:1])
    wrong = weights.copy()
    wrong[:, 3] += 0.1  # J in the weight of the first rod
    errors = [
        next(
            m.values for m in pointwise(model, torch.from_numpy(w), one, DAMPED, "test", Gauge.RAW) if "part" in m.name
        )
        for w in (weights, wrong)
    ]
    np.testing.assert_allclose(errors[0], 0, atol=1e-12)
    cosine = np.cos(one.q[0, :, 1])
    np.testing.assert_allclose(errors[1], 0.1 * np.abs(cosine - cosine.mean()).mean(), rtol=1e-9)


@pytest.mark.parametrize("structure", ["canonical", "free", "full"])
@pytest.mark.parametrize("momentum_hidden", [None, (3,)])
@pytest.mark.parametrize("non_negative", ["softplus", "relu"])
def test_it_is_passive_for_any_weights(data, structure, momentum_hidden, non_negative):
    """Theorem 1 for the interconnection: R_I of the parts and of the joint between them together."""
    options = replace(HINGED, structure=structure, momentum_hidden=momentum_hidden, non_negative=non_negative)
    model = build(_context(data), options)
    generators = [np.random.default_rng(seed) for seed in range(3)]
    weights = model.initial(generators) + [generator.normal(size=model.n_parameters) for generator in generators]
    states = States.random(DAMPED.coordinates, model.velocity_scale, 100, generators[0])
    assert worst_margin(model, weights, states).max() <= 1e-9


@pytest.mark.slow
def test_both_sub_systems_are_learned_jointly_and_passive_at_every_step(data):
    """From (12b) alone: tau to 1e-3 of its size after 60 iterations, the margin of Theorem 1 at each of them."""
    model = build(_context(data), HINGED)
    start = torch.from_numpy(model.initial([np.random.default_rng(s) for s in range(2)]))
    states = States.random(DAMPED.coordinates, model.velocity_scale, 50, np.random.default_rng(1))
    task = make_task(model, data.train, Objective(port.Options()), error_scale=20.0)
    problem = TrainingProblem(model, [task], range(2), watches=[PassivityWatch(model, states)])
    fitted = LevenbergMarquardt(restarts=1, iterations=60).fit(problem, start, silent, NoCheckpoint())
    margins = [value.max() for _, name, value in fitted.curves if name == "passivity_margin"]
    assert len(margins) >= 60 and max(margins) <= 1e-9
    q, qd, tau = data.test.q[0], data.test.qd[0], data.test.tau[0]
    error = _accelerations(model, fitted.parameters[0].numpy(), q, qd, tau) - data.test.qdd[0]
    assert np.median(np.abs(error)) < 1e-2 * np.abs(data.test.qdd[0]).mean()


def test_trained_parts_are_kept_or_are_where_the_fit_starts(data):
    cart, rod = Lagrangian(t1, 2), Lagrangian(rigid_body, 3)
    parts = _context(data, (cart, CART), (rod, ROD))
    frozen, free = (build(parts, replace(HINGED, frozen=frozen)) for frozen in (True, False))
    assert (frozen.fixed, free.fixed) == (slice(0, 7), slice(0, 0))
    np.testing.assert_array_equal(free.initial([np.random.default_rng(0)])[:, :7], [[*CART, *ROD]])


def test_what_cannot_be_joined_is_refused(data):
    cart, rod = (Lagrangian(t1, 2), CART), (Lagrangian(rigid_body, 3), ROD)
    for parts in ([cart], [rod, cart]):
        with pytest.raises(UserError, match="cart with a rod and a free rod"):
            build(_context(data, *parts), HINGED)
    dry = Damped(Lagrangian(t1, 2), "coulomb")
    with pytest.raises(UserError, match="not linear in rates"):
        build(_context(data, (dry, np.zeros(dry.n_parameters)), rod), HINGED)
    assert HINGED.system_problem(DAMPED) is None
    assert "system=sip" in HINGED.system_problem(load("sip"))
    assert [*replace(HINGED, energy="basis", parts=("cart_rod", "free_rod")).problems()]
