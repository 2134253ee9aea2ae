"""The generalised force of inputs, of constant and of turning directions."""

import casadi as ca
import numpy as np
import pytest

from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import (
    generalised_force,
    input_limits,
    input_map,
    input_matrix,
    inputs_from_force,
    is_constant,
    under_inputs,
)
from repro.mechanics.simulate import simulate
from repro.mechanics.system import load
from repro.mechanics.system_options import SYSTEMS
from repro.plugins.plugin import plugin_names

pytestmark = pytest.mark.usefixtures("unoptimised")

SYSTEMS = [load(name) for name in plugin_names(SYSTEMS)]
QUADROTOR = load("quadrotor")
every_system = pytest.mark.parametrize("system", SYSTEMS, ids=lambda system: system.name)


@every_system
def test_the_map_is_the_same_in_numbers_and_expressions(system):
    q = np.random.default_rng(0).normal(size=(5, system.n_q))
    matrices = input_matrix(system, q)
    assert matrices.shape == (5, system.n_q, len(system.inputs))
    for at, matrix in zip(q, matrices, strict=True):
        np.testing.assert_array_equal(matrix, np.array(system.input_map(at, np), dtype=float))
        np.testing.assert_array_equal(matrix, np.asarray(input_map(system)(at)))
    assert is_constant(system) == bool(np.ptp(matrices, axis=0).max() == 0)
    assert np.all(input_limits(system) > 0) and len({each.name for each in system.inputs}) == len(system.inputs)


@every_system
def test_inputs_are_found_from_their_force(system):
    generator = np.random.default_rng(1)
    q, u = generator.normal(size=(2, 5, system.n_q)), generator.normal(size=(2, 5, len(system.inputs)))
    np.testing.assert_allclose(inputs_from_force(system, q, generalised_force(system, q, u)), u, atol=1e-12)


@every_system
def test_the_accelerations_are_those_under_the_force(system):
    generator = np.random.default_rng(2)
    q, qd, u = (
        generator.normal(size=system.n_q),
        generator.normal(size=system.n_q),
        generator.normal(size=len(system.inputs)),
    )
    acceleration = dynamics_of(system).acceleration
    tau = generalised_force(system, q, u)
    np.testing.assert_allclose(
        np.asarray(under_inputs(acceleration, system)(q, qd, u, [])),
        np.asarray(acceleration(q, qd, tau, [])),
        rtol=1e-12,
        atol=1e-12,
    )


@pytest.mark.parametrize("system", [*filter(is_constant, SYSTEMS)], ids=lambda system: system.name)
def test_a_motion_under_constant_directions_is_the_motion_under_their_force_to_the_bit(system):
    generator = np.random.default_rng(3)
    start = generator.uniform(-1, 1, (3, 2 * system.n_q))
    u = generator.uniform(-2, 2, (3, 20, len(system.inputs)))
    tau = u @ input_matrix(system, np.zeros(system.n_q)).T
    acceleration = dynamics_of(system).acceleration
    np.testing.assert_array_equal(
        simulate(under_inputs(acceleration, system), start, u, 0.04), simulate(acceleration, start, tau, 0.04)
    )


def test_engines_hold_the_inputs_while_their_force_turns():
    """One thrust of half the weight on each side keeps a level body where it is; on a tilted one it does not."""
    motion = under_inputs(dynamics_of(QUADROTOR).acceleration, QUADROTOR)
    thrust = np.full((1, 30, 2), QUADROTOR.m1 * QUADROTOR.g / 2)
    level = simulate(motion, np.zeros((1, 6)), thrust, 0.04)
    np.testing.assert_allclose(level, 0, atol=1e-12)
    turning = np.array([[0.0, 0.0, 0.1, 0.0, 0.0, 2.0]])
    one, other = (simulate(motion, turning, thrust, 0.04, engine=engine) for engine in ("c", "casadi"))
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
    theta = 0.1 + 2.0 * 0.04 * np.arange(31)
    np.testing.assert_allclose(one[0, :, 2], theta, atol=1e-12)
    # the acceleration -g sin(theta), integrated twice by hand
    expected = 9.8 / 4 * (np.sin(theta) - np.sin(0.1)) - 9.8 / 2 * np.cos(0.1) * 0.04 * np.arange(31)
    np.testing.assert_allclose(one[0, :, 0], expected, atol=1e-6)


def test_matrix_expressions_take_the_map():
    q = ca.MX.sym("q", 3)
    matrix = ca.Function("map", [q], [input_map(QUADROTOR)(q)])
    at = np.array([0.3, -0.2, 0.7])
    np.testing.assert_array_equal(np.asarray(matrix(at)), input_matrix(QUADROTOR, at))
