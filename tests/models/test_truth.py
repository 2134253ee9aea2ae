"""The true Lagrangian as a model: its energies are the system's, its coefficients too."""

import casadi
import numpy as np
import pytest

from repro.errors import UserError
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.mechanics.system_options import SYSTEMS
from repro.models.bases import t1
from repro.models.context import Context
from repro.models.kinds.degenerate import Degenerate, driven_cyclic
from repro.models.kinds.truth import Options, Truth, build, true_model
from repro.plugins.plugin import plugin_names

READINGS = [
    ("sip", "physical"),
    ("sip", "printed"),
    ("sip_rod", "physical"),
    ("dip", "physical"),
    ("cart_rods", "physical"),
]


@pytest.mark.parametrize(("name", "reading"), READINGS)
def test_energies_are_those_of_the_system(name, reading):
    system = load(name, reading)
    model = Truth(system)
    (weights,) = model.initial([np.random.default_rng(0)])
    q, qd = np.random.default_rng(1).normal(size=(2, system.n_q))
    said = model.energies(casadi.SX(q), casadi.SX(qd), casadi.SX(weights))
    dynamics = dynamics_of(system)
    assert float(said.kinetic) == pytest.approx(float(dynamics.kinetic(q, qd, [])), abs=1e-12)
    assert float(said.potential) == pytest.approx(float(dynamics.potential(q, qd, [])), abs=1e-12)


def test_its_friction_is_that_of_the_joints():
    system = load("dip", damping=[0.1, 0.02, 0.03])
    zeros = np.zeros((1, 2, 3))
    model = build(Context(t1, system.coordinates, zeros, zeros, zeros, system), Options(damping="diagonal"))
    weights = model.initial([np.random.default_rng(seed) for seed in range(2)])
    np.testing.assert_array_equal(weights[:, -3:], [[0.1, 0.02, 0.03]] * 2)
    q, qd, tau = np.random.default_rng(1).normal(size=(3, 3))
    symbols = [casadi.SX.sym(name, 3) for name in ("q", "qd", "tau")]
    ours = casadi.Function("ours", symbols, [model.acceleration(*symbols, casadi.SX(weights[0]))])
    expected = dynamics_of(system).acceleration(q, qd, tau, [])
    np.testing.assert_allclose(np.asarray(ours(q, qd, tau)), np.asarray(expected), rtol=1e-10)


def test_without_the_true_system_it_is_refused():
    zeros = np.zeros((1, 2, 2))
    with pytest.raises(UserError, match="data=file"):
        build(Context(t1, load("sip").coordinates, zeros, zeros, zeros, None), Options())


FRICTION = [
    *((name, {"coulomb": [0.2] * load(name).n_q}) for name in plugin_names(SYSTEMS)),
    *((name, {"damping_frame": "absolute"}) for name in ("sip", "dip")),
    *((name, {"damping_growth": 2.0}) for name in ("sip", "dip")),
]


@pytest.mark.parametrize(("name", "friction"), FRICTION)
def test_any_system_moves_as_its_model(name, friction):
    """With friction, and without weights where it is no chain with a viscous coefficient per joint."""
    n_q = load(name).n_q
    system = load(name, damping=[0.1] * n_q, **friction)
    model = true_model(system, damped=True)
    q, qd, tau = np.random.default_rng(1).normal(size=(3, n_q))
    symbols = [casadi.SX.sym(name, n_q) for name in ("q", "qd", "tau")]
    (weights,) = model.initial([np.random.default_rng(0)])
    ours = casadi.Function("ours", symbols, [model.acceleration(*symbols, casadi.SX(weights))])
    expected = dynamics_of(system).acceleration(q, qd, tau, [])
    np.testing.assert_allclose(np.asarray(ours(q, qd, tau)), np.asarray(expected), rtol=1e-9, atol=1e-12)


def test_the_misprinted_double_pendulum_is_a_model_without_weights():
    with pytest.raises(UserError, match="no chain's"):
        Truth(load("dip", "printed"))
    assert true_model(load("dip", "printed"), damped=False).n_parameters == 0


@pytest.mark.parametrize("name", plugin_names(SYSTEMS))
def test_the_degenerate_model_is_exact_along_the_driven_cyclic_coordinate_or_refused(name):
    system = load(name)
    index = driven_cyclic(system)
    if index is None:
        with pytest.raises(UserError, match=f"system={name} has none"):
            Degenerate(system)
        return
    if name == "motor_pendulum":
        pytest.skip("the current exchanges momentum with the rotor")
    model = Degenerate(system)
    symbols = [casadi.SX.sym(name, system.n_q) for name in ("q", "qd", "qdd")]
    ours = casadi.Function("ours", symbols, [model.inverse_dynamics(*symbols, casadi.SX(0, 1))])
    at = np.random.default_rng(1).normal(size=(3, system.n_q))
    expected = dynamics_of(system).inverse(*at, [])
    assert float(ours(*at)[index]) == pytest.approx(float(expected[index]), rel=1e-9)
