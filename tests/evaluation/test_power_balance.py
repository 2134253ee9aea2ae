"""Power by hand, and for inputs whose directions turn with the coordinates."""

import numpy as np
import pytest

from repro.codegen.array_evaluation import evaluate
from repro.evaluation.power_balance import power_balance, supplied_power
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import under_inputs
from repro.mechanics.simulate import simulate
from repro.mechanics.system import load

TIME = np.array([0.0, 0.5, 1.5])
Q = np.array([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [2.0, -1.0, 0.0]])
STATES = np.concatenate([Q, np.random.default_rng(0).normal(size=Q.shape)], axis=1)
U = np.array([[2.0, 5.0, 1.0], [3.0, 0.5, 1.0], [9.0, 9.0, 1.0]])


def test_every_input_supplies_power_over_its_step():
    rod = load("rod")
    expected = [2.0 * 1.0 / 0.5, (3.0 * 1.0 - 0.5 * 2.0) / 1.0]
    np.testing.assert_allclose(supplied_power(rod, STATES, U, TIME), expected)
    np.testing.assert_array_equal(
        supplied_power(rod, STATES[None], U[None], TIME)[0], supplied_power(rod, STATES, U, TIME)
    )


def test_what_is_not_stored_is_dissipated():
    balance = power_balance(load("rod"), STATES, U, np.array([0.0, 1.5, 3.0]), TIME)
    np.testing.assert_allclose(balance["dH/dt"], [3.0, 1.5, 0.0])
    np.testing.assert_allclose(balance["dissipated"], [1.0, 0.5, 0.0])


@pytest.mark.parametrize("steps", [20, 40])
def test_inputs_that_turn_with_a_body_supply_what_is_stored(steps):
    """No damping: the error of Simpson's rule on a step is of fifth order in its length."""
    time = np.linspace(0.0, 1.0, steps + 1)
    u = np.repeat(np.random.default_rng(1).uniform(-2, 2, (1, 20, 2)), steps // 20, axis=1)
    quadrotor = load("quadrotor")
    dynamics = dynamics_of(quadrotor)
    motion = under_inputs(dynamics.acceleration, quadrotor)
    states = simulate(motion, np.zeros((1, 6)), u, 1.0 / steps)[0]
    energy = evaluate(dynamics.hamiltonian, states[:, :3], states[:, 3:])[:, 0]
    held = np.append(u[0], u[0, -1:], axis=0)
    balance = power_balance(quadrotor, states, held, energy, time)
    assert np.abs(balance["supplied"]).max() > 1.0
    assert np.abs(balance["dissipated"]).max() < 2e-3 * (20 / steps) ** 3
