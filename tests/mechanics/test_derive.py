import casadi as ca
import numpy as np
import pytest

from repro.codegen.array_evaluation import BLOCK, evaluate
from repro.mechanics.derive import Dynamics, derive, dynamics_of, euler_lagrange
from repro.mechanics.system import System, load
from repro.mechanics.system_options import SYSTEMS
from repro.plugins.plugin import plugin_names

every_system = pytest.mark.parametrize(
    "system", [load(name) for name in plugin_names(SYSTEMS)] + [load(name, "printed") for name in ("sip", "dip")]
)


def sampled(n_q: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random q, qd, qdd (30, n_q)."""
    random = np.random.default_rng(0)
    return random.uniform(-4, 4, (30, n_q)), random.uniform(-9, 9, (30, n_q)), random.uniform(-30, 30, (30, n_q))


@pytest.fixture
def points() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return sampled(2)


def test_inverse_of_the_printed_pendulum_is_equation_13(points: tuple) -> None:
    q, qd, qdd = points
    m0, m1, L1, g = 0.6, 0.2, 0.5, 9.8
    theta, thetad, xdd, thetadd = q[:, 1], qd[:, 1], qdd[:, 0], qdd[:, 1]
    force = (m0 + m1) * xdd + m1 * L1 * thetadd * np.cos(theta) - m1 * L1 * thetad**2 * np.sin(theta)
    nothing = m1 * L1 * xdd * np.cos(theta) + m1 * L1**2 * thetadd + m1 * g * L1 * np.sin(theta)
    tau = evaluate(dynamics_of(load("sip", "printed")).inverse, q, qd, qdd)
    np.testing.assert_allclose(tau, np.stack([force, nothing], axis=-1), rtol=1e-13, atol=1e-13)


@every_system
def test_acceleration_undoes_inverse(system) -> None:
    q, qd, qdd = sampled(system.n_q)
    dynamics = dynamics_of(system)
    tau = evaluate(dynamics.inverse, q, qd, qdd)
    np.testing.assert_allclose(evaluate(dynamics.acceleration, q, qd, tau), qdd, rtol=1e-10, atol=1e-10)


@every_system
def test_legendre_transform_gives_the_sum_of_energies(system) -> None:
    q, qd, _ = sampled(system.n_q)
    dynamics = dynamics_of(system)
    kinetic, potential = evaluate(dynamics.kinetic, q, qd)[:, 0], evaluate(dynamics.potential, q, qd)[:, 0]
    np.testing.assert_allclose(evaluate(dynamics.hamiltonian, q, qd)[:, 0], kinetic + potential, rtol=1e-12, atol=1e-12)
    coupling = np.array([system.coupling(*pair, np) for pair in zip(q, qd, strict=True)])
    lagrangian = evaluate(dynamics.lagrangian, q, qd)[:, 0]
    np.testing.assert_allclose(lagrangian, kinetic + coupling - potential, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(kinetic, [system.kinetic(*pair, np) for pair in zip(q, qd, strict=True)])
    np.testing.assert_allclose(potential, [system.potential(point, np) for point in q])


@every_system
def test_momentum_is_mass_times_velocity_and_mass_is_positive_definite(system) -> None:
    q, qd, _ = sampled(system.n_q)
    dynamics = dynamics_of(system)
    mass = evaluate(dynamics.mass_matrix, q, qd).reshape(30, system.n_q, system.n_q)
    gyroscopic = evaluate(dynamics.momentum, q, 0 * qd)
    momentum = np.einsum("nij,nj->ni", mass, qd) + gyroscopic
    np.testing.assert_allclose(evaluate(dynamics.momentum, q, qd), momentum, atol=1e-12)
    assert type(system).coupling is not System.coupling or not gyroscopic.any()
    assert np.linalg.eigvalsh(mass).min() > 0


@every_system
def test_power_balance_holds_pointwise(system) -> None:
    """DH/dt = qd . tau, with dH/dt by central differences along the motion."""
    q, qd, tau = sampled(system.n_q)
    dynamics = dynamics_of(system)
    qdd = evaluate(dynamics.acceleration, q, qd, tau)
    step = 1e-6
    ahead = evaluate(dynamics.hamiltonian, q + step * qd, qd + step * qdd)
    behind = evaluate(dynamics.hamiltonian, q - step * qd, qd - step * qdd)
    np.testing.assert_allclose((ahead - behind)[:, 0] / (2 * step), (qd * tau).sum(-1), rtol=1e-5, atol=1e-5)


def test_total_time_derivatives_are_in_the_null_space_of_the_operator() -> None:
    q, qd, qdd = ca.SX.sym("q", 2), ca.SX.sym("qd", 2), ca.SX.sym("qdd", 2)
    anything = ca.sin(q[0]) * ca.exp(q[1]) + q[0] ** 3
    functions = ca.vertcat(ca.jtimes(anything, q, qd), 0.5 * ca.sumsqr(qd), q[0] * q[1])
    columns = ca.Function("columns", [q, qd, qdd], [ca.densify(euler_lagrange(functions, q, qd, qdd))])
    values = evaluate(columns, *np.random.default_rng(0).normal(size=(3, 2)))
    point = np.random.default_rng(0).normal(size=(3, 2))
    assert values.shape == (2, 3)
    np.testing.assert_allclose(values[:, 0], 0, atol=1e-14)
    np.testing.assert_allclose(values[:, 1], point[2])
    np.testing.assert_allclose(values[:, 2], -point[0][::-1])


def quadratic(n_q: int) -> Dynamics:
    """Learned-model-like dynamics: a constant mass matrix given as parameters, V = sum of squares."""
    q, qd, entries = ca.SX.sym("q", n_q), ca.SX.sym("qd", n_q), ca.SX.sym("M", n_q * (n_q + 1) // 2)
    mass = ca.tril2symm(ca.SX(ca.Sparsity.lower(n_q), entries))
    return derive(0.5 * ca.bilin(mass, qd, qd), ca.sumsqr(q), ca.SX(0), q, qd, entries)


@pytest.mark.parametrize("n_q", [1, 2, 3, 4, 6])
def test_indefinite_mass_matrices_are_solved(n_q: int) -> None:
    random = np.random.default_rng(n_q)
    dynamics = quadratic(n_q)
    entries = random.normal(size=n_q * (n_q + 1) // 2)
    q, qd, tau = random.normal(size=(3, n_q))
    mass = evaluate(dynamics.mass_matrix, q, qd, entries).reshape(n_q, n_q)
    if n_q > 1:
        assert np.linalg.eigvalsh(mass).min() < 0 < np.linalg.eigvalsh(mass).max()
    expected = np.linalg.solve(mass, tau - 2 * q)
    np.testing.assert_allclose(evaluate(dynamics.acceleration, q, qd, tau, entries), expected, rtol=1e-9)


def test_a_zero_leading_pivot_does_no_harm() -> None:
    entries = np.array([0.0, 2.0, 0.0])
    acceleration = evaluate(quadratic(2).acceleration, np.zeros(2), np.zeros(2), np.array([4.0, 6.0]), entries)
    np.testing.assert_allclose(acceleration, [3.0, 2.0])


def test_kinetic_energy_need_not_be_quadratic() -> None:
    """Relativistic mass: L = -sqrt(1 - v^2), p = v / sqrt(1 - v^2), H = 1 / sqrt(1 - v^2)."""
    q, qd = ca.SX.sym("q", 1), ca.SX.sym("qd", 1)
    dynamics = derive(-ca.sqrt(1 - qd**2), ca.SX(0), ca.SX(0), q, qd)
    speed = np.array([[0.0], [0.6], [0.8]])
    gamma = 1 / np.sqrt(1 - speed**2)
    np.testing.assert_allclose(evaluate(dynamics.momentum, np.zeros(1), speed), gamma * speed)
    np.testing.assert_allclose(evaluate(dynamics.hamiltonian, np.zeros(1), speed), gamma)
    np.testing.assert_allclose(evaluate(dynamics.acceleration, np.zeros(1), speed, np.ones(1)), gamma**-3)


def test_evaluate_broadcasts_and_keeps_leading_axes() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    function = ca.Function("f", [x, p], [ca.horzcat(x, 2 * x, x * p[0])])
    points = np.random.default_rng(0).normal(size=(2, BLOCK, 2))
    weights = np.array([7.0, 0.0, 0.0])
    values = evaluate(function, points, weights)
    assert values.shape == (2, BLOCK, 2, 3)
    np.testing.assert_allclose(values, points[..., None] * np.array([1.0, 2.0, 7.0]))
    np.testing.assert_allclose(evaluate(function, points[1, 5], weights), values[1, 5])
    np.testing.assert_allclose(evaluate(function, points[:, :1001], weights), values[:, :1001])
    assert evaluate(function, points[:, :0], weights).shape == (2, 0, 2, 3)
    with pytest.raises(ValueError, match=r"takes vectors of \[2, 3\]"):
        evaluate(function, points)
