"""Energy shaping: its force in closed form, what it takes from the model, and that it swings one link up."""

import casadi
import numpy as np
import pytest
from cart_task import erect, hanging_start

from repro.control.closed_loop import run_loop
from repro.control.conditions import Conditions, Start
from repro.control.controllers.energy_shaping import EnergyShaping, Laws, Options, lqr
from repro.control.predictive_model import PredictiveModel
from repro.mechanics.system import load
from repro.models.kinds.truth import Exact, Truth, true_model
from repro.models.model import EnergyExpressions

SHIFT = 0.3  # J s / rad, of a total derivative that no motion depends on


class InAnotherGauge(Exact):
    """The true energies plus constants, and T plus the rate of SHIFT sin(theta)."""

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T and V in that gauge."""
        true = super().energies(q, qd, parameters)
        total_derivative = SHIFT * casadi.cos(q[1]) * qd[1]
        return EnergyExpressions(true.kinetic + 7.0 + total_derivative, true.potential - 2.0)


def shaping(system, model, x_des=0.8, *, weights=None, canonical=True, **options):
    if weights is None:
        (weights,) = model.initial([np.random.default_rng(0)])
    chosen = Options(force_limit=4.0, **options)
    return EnergyShaping(Laws(PredictiveModel(model, system, canonical)), weights, erect(system, x_des), chosen)


def forces(controller, states):
    return np.array([controller.decide(state).u[0] for state in states])


def away_from_upright(n=50):
    return np.random.default_rng(3).uniform([-1.0, 0.5, -1.0, -3.0], [1.0, 5.8, 1.0, 3.0], (n, 4))


def closed_form(states, total, coupling, inertia, weight, *, x_des=0.8, energy=10.0, position=4.0, speed=3.0):
    """The swing-up of T = total xd^2 / 2 + coupling cos(th) xd thd + inertia thd^2 / 2 and V = weight cos(th)."""
    x, theta, xd, thd = states.T
    sine, cosine = np.sin(theta), np.cos(theta)
    missing = 0.5 * inertia * thd**2 + weight * (cosine - 1)
    cart = energy * missing * np.sign(coupling * cosine) * abs(cosine) * thd - position * (x - x_des) - speed * xd
    turning = (weight * sine - coupling * cosine * cart) / inertia
    return np.clip(total * cart + coupling * (cosine * turning - sine * thd**2), -4, 4)


@pytest.mark.parametrize("gains", [{}, {"energy_gain": 2.0, "position_gain": 1.0, "speed_gain": 0.5}])
def test_the_swing_up_is_the_closed_form(gains):
    system = load("sip")
    total, inertia = system.m0 + system.m1, system.m1 * system.L1**2
    constants = total, system.m1 * system.L1, inertia, system.m1 * system.g * system.L1
    expected = closed_form(
        away_from_upright(), *constants, **{name.removesuffix("_gain"): value for name, value in gains.items()}
    )
    computed = forces(shaping(system, Truth(system), **gains), away_from_upright())
    np.testing.assert_allclose(computed, expected, atol=1e-10)
    assert np.sum(abs(computed) < 4) > 5  # the limit does not hide the law


def test_the_force_comes_from_the_weights_of_the_model():
    system, wrong = load("sip"), np.array([1.2, 0.8, 1.3, 0.9])
    model = Truth(system)
    (weights,) = model.initial([np.random.default_rng(0)])
    by_name = dict(zip(model.coefficient_names, weights * wrong, strict=True))
    squares, product = by_name["xd^2"], by_name["xd thd1 cos(th1)"]
    constants = 2 * squares, product, 2 * by_name["thd1^2"], by_name["cos(th1)"]
    computed = forces(shaping(system, model, weights=weights * wrong), away_from_upright())
    np.testing.assert_allclose(computed, closed_form(away_from_upright(), *constants), atol=1e-10)


@pytest.mark.parametrize("canonical", [True, False])
def test_the_force_does_not_depend_on_the_gauge_of_the_energies(canonical):
    system = load("sip_rod")
    states = np.random.default_rng(4).uniform(-3, 3, (50, 4))
    expected = forces(shaping(system, Exact(system)), states)
    found = forces(shaping(system, InAnotherGauge(system), canonical=canonical), states)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_the_regulator_takes_over_within_the_region_to_catch():
    system = load("sip")
    near = np.array([[0.8, 0.5, 0.0, -1.0]])
    swung, caught = (
        forces(shaping(system, Truth(system), catch_angle=angle, position_gain=0.0, speed_gain=0.0), near)
        for angle in (0.4, 0.6)
    )
    assert swung == pytest.approx(closed_form(near, 0.8, 0.1, 0.05, 0.98, position=0.0, speed=0.0), abs=1e-10)
    assert abs(caught - swung) > 0.1


@pytest.mark.parametrize("name", ["sip", "sip_rod"])
def test_it_swings_up_and_goes_to_the_place(name):
    system = load(name)
    controller = shaping(system, true_model(system, damped=False))
    start = hanging_start(system, 0.8)
    loop = run_loop(system, controller, start, Conditions(), time_step=0.04, seconds=8.0, disc=None)
    assert loop.outcome.success and np.abs(loop.inputs).max() <= 4.0


def test_the_regulator_holds_near_upright():
    system = load("sip", "printed")
    start = Start("near", np.array([0.5, np.pi + 0.1, 0.0, 0.0]), erect(system, 0.5), (0,))
    controller = shaping(system, Truth(system), 0.5)
    loop = run_loop(system, controller, start, Conditions(), time_step=0.04, seconds=6.0, disc=None)
    assert loop.outcome.success
    assert np.abs(loop.states[:, 1] - np.pi).max() < 0.3


def test_the_regulator_minimises_its_cost():
    # the force reaches the first state alone, whose gain is that of a scalar Riccati equation
    step = 0.5
    of_state, of_force = np.diag([-1.0, -2.0, -3.0, -4.0]), np.array([[1.0], [0.0], [0.0], [0.0]])
    a, b = np.exp(-step), 1 - np.exp(-step)
    value = 10.0
    for _ in range(200):
        value = 10 + a**2 * value - (a * b * value) ** 2 / (1 + b**2 * value)
    expected = [a * b * value / (1 + b**2 * value), 0, 0, 0]
    np.testing.assert_allclose(lqr(of_state, of_force, step), expected, atol=1e-10)


@pytest.mark.parametrize("of_force", [0.0, np.inf], ids=["that no force reaches", "with a singular mass matrix"])
def test_a_model_has_no_regulator(of_force):
    unstable = np.diag([1.0, 1.0, -1.0, -1.0])
    np.testing.assert_array_equal(lqr(unstable, np.full((4, 1), of_force), 0.04), np.zeros(4))
