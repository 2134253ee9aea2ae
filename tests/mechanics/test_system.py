import math

import numpy as np
import pytest

from repro.errors import UserError
from repro.mechanics.derive import dynamics_of, evaluate
from repro.mechanics.simulate import simulate
from repro.mechanics.system import DAMPING_FRAMES, READINGS, System, load, names

every_system = pytest.mark.parametrize("system", [load(name, reading) for name in names() for reading in READINGS])


def states(system: System, count: int = 50) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(1)
    return random.uniform(-3, 3, (count, system.n_q)), random.uniform(-5, 5, (count, system.n_q))


@every_system
def test_upright_is_highest_and_hanging_is_lowest(system: System) -> None:
    q, _ = states(system)
    potential = [system.potential(list(point), np) for point in q]
    assert system.potential(system.upright, np) > max(potential)
    assert system.potential(system.hanging, np) < min(potential)


@every_system
def test_links_point_up_when_upright(system: System) -> None:
    up, down = (np.array(system.body_points(list(q), np)) for q in (system.upright, system.hanging))
    assert np.all(np.diff(up[:, 1]) > 0)
    assert np.all(np.diff(down[:, 1]) < 0)
    np.testing.assert_allclose(up[:, 0], 0, atol=1e-15)


@every_system
def test_both_rest_positions_are_equilibria(system: System) -> None:
    rest = np.zeros(system.n_q)
    for q in (system.upright, system.hanging):
        acceleration = evaluate(dynamics_of(system).acceleration, q, rest, rest)
        np.testing.assert_allclose(acceleration, 0, atol=1e-14)


@every_system
def test_body_points_move_as_the_coordinates_say(system: System) -> None:
    q, _ = states(system)
    points = np.array([system.body_points(list(point), np) for point in q])
    np.testing.assert_allclose(points[:, 0], np.c_[q[:, 0], 0 * q[:, 0]])
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    np.testing.assert_allclose(lengths, np.broadcast_to(lengths[0], lengths.shape))


def test_kinetic_energy_of_the_point_mass_is_that_of_its_points() -> None:
    system = load("sip")
    q, qd = states(system)
    step = 1e-6
    ahead, behind = (
        np.array([system.body_points(list(point), np) for point in q + sign * step * qd]) for sign in (1, -1)
    )
    speed_squared = (((ahead - behind) / (2 * step)) ** 2).sum(axis=-1)
    expected = 0.5 * speed_squared @ np.array([0.6, 0.2])
    np.testing.assert_allclose([system.kinetic(*pair, np) for pair in zip(q, qd, strict=True)], expected, rtol=1e-8)


def test_kinetic_energy_of_the_rod_is_the_integral_over_its_length() -> None:
    system = load("sip_rod")
    q, qd = states(system)
    nodes, weights = np.polynomial.legendre.leggauss(3)
    along = (nodes + 1) / 2 * 0.5
    velocity_x = qd[:, :1] + along * qd[:, 1:] * np.cos(q[:, 1:])
    velocity_y = along * qd[:, 1:] * np.sin(q[:, 1:])
    rod = 0.5 * (velocity_x**2 + velocity_y**2) @ (0.2 * weights / 2)
    expected = 0.5 * 0.6 * qd[:, 0] ** 2 + rod
    np.testing.assert_allclose([system.kinetic(*pair, np) for pair in zip(q, qd, strict=True)], expected)


@pytest.mark.parametrize("name", names())
def test_readings_are_equivalent_under_the_mirror_map(name: str) -> None:
    physical, printed = (load(name, reading, damping=None) for reading in READINGS)
    turns = np.array([-1.0 if coordinate.is_angle else 1.0 for coordinate in physical.coordinates])
    shift = np.array([math.pi if coordinate.is_angle else 0.0 for coordinate in physical.coordinates])
    q, qd = states(physical)
    tau = np.random.default_rng(2).normal(size=q.shape)
    one = evaluate(dynamics_of(physical).acceleration, q, qd, tau)
    other = evaluate(dynamics_of(printed).acceleration, shift + turns * q, turns * qd, turns * tau)
    np.testing.assert_allclose(other, turns * one, rtol=1e-11, atol=1e-11)
    for point in q:
        here, there = physical.body_points(list(point), np), printed.body_points(list(shift + turns * point), np)
        np.testing.assert_allclose(here, there, atol=1e-14)
    force = np.zeros((1, 50, physical.n_q))
    force[..., 0] = 2.0
    start = np.concatenate([q[:1], qd[:1]], axis=1)
    mirrored = np.concatenate([shift + turns * q[:1], turns * qd[:1]], axis=1)
    run = simulate(dynamics_of(physical).acceleration, start, force, 0.04)
    mirror_run = simulate(dynamics_of(printed).acceleration, mirrored, force, 0.04)
    np.testing.assert_allclose(
        mirror_run, np.concatenate([shift, 0 * shift]) + np.concatenate([turns, turns]) * run, atol=1e-6
    )


@pytest.mark.parametrize("frame", DAMPING_FRAMES)
def test_damping_takes_the_rayleigh_power_out(frame: str) -> None:
    system = load("sip", damping=[0.3, 0.02], damping_frame=frame)
    q, qd = states(system)
    dynamics = dynamics_of(system)
    lost = evaluate(dynamics.dissipated_power, q, qd)[:, 0]
    np.testing.assert_allclose(lost, 0.3 * qd[:, 0] ** 2 + 0.02 * qd[:, 1] ** 2)
    force = np.zeros((1, 1, 2))
    start = np.concatenate([q[:1], qd[:1]], axis=1)
    step = 1e-4
    x = simulate(dynamics.acceleration, start, force, step)[0]
    energy = evaluate(dynamics.hamiltonian, x[:, :2], x[:, 2:])[:, 0]
    power = evaluate(dynamics.dissipated_power, x[:, :2], x[:, 2:])[:, 0].mean()
    assert energy[0] - energy[1] == pytest.approx(step * power, rel=1e-6)


def test_relative_damping_sees_the_rates_between_links() -> None:
    from repro.mechanics.system import Coordinate
    from repro.mechanics.systems.sip import SinglePendulum

    class Chain(SinglePendulum):
        coordinates = (*SinglePendulum.coordinates, Coordinate("theta2", "rad", True))

    qd = [0.5, 2.0, -1.0]
    relative = Chain(damping=(1.0, 2.0, 3.0)).dissipation([0.0] * 3, qd, np)
    absolute = Chain(damping=(1.0, 2.0, 3.0), damping_frame="absolute").dissipation([0.0] * 3, qd, np)
    matrix = np.array([[1.0, 0, 0], [0, 2.0 + 3.0, -3.0], [0, -3.0, 3.0]])
    assert relative == pytest.approx(0.5 * np.array(qd) @ matrix @ qd)
    assert absolute == pytest.approx(0.5 * (1.0 * 0.25 + 2.0 * 4.0 + 3.0 * 1.0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "tripod"}, "sip_rod"),
        ({"name": "sip", "reading": "literal"}, "printed"),
        ({"name": "sip", "damping_frame": "joint"}, "relative"),
        ({"name": "sip", "damping": [0.1]}, "2 non-negative"),
        ({"name": "sip", "damping": [0.1, -0.1]}, "2 non-negative"),
        ({"name": "sip", "damping": [0.1, math.nan]}, "2 non-negative"),
    ],
)
def test_what_is_not_allowed_is_said(arguments: dict, message: str) -> None:
    with pytest.raises(UserError, match=message):
        load(**arguments)


def test_description_is_plain_and_complete() -> None:
    assert load("sip", "printed", [0, 0.1]).describe() == {
        "name": "sip",
        "reading": "printed",
        "damping": [0.0, 0.1],
        "damping_frame": "relative",
        "m0": 0.6,
        "m1": 0.2,
        "L1": 0.5,
        "g": 9.8,
    }
