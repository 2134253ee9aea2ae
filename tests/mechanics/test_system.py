import math

import numpy as np
import pytest

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.mechanics.chain import Chain, LinkAngles
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System, load
from repro.mechanics.system_options import SYSTEMS, Reading
from repro.plugins.plugin import plugin_names

MISPRINTED = ("dip", "printed")  # its T and V are not those of its bodies
READ = [name for name in plugin_names(SYSTEMS) if isinstance(load(name), LinkAngles)]
SYSTEMS = [load(name, reading) for name in READ for reading in Reading if (name, reading) != MISPRINTED]

CHAINS = [system for system in SYSTEMS if isinstance(system, Chain)]


def _id(system: System) -> str:
    return f"{system.name}-{system.reading}"


every_chain = pytest.mark.parametrize("system", CHAINS, ids=_id)


def states(system: System, count: int = 50) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(1)
    return random.uniform(-3, 3, (count, system.n_q)), random.uniform(-5, 5, (count, system.n_q))


def speeds(system: System, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Squared speeds (state, point) of the body points, by central differences."""
    step = 1e-6
    ahead, behind = (
        np.array([system.body_points(list(point), np) for point in q + sign * step * qd]) for sign in (1, -1)
    )
    return (((ahead - behind) / (2 * step)) ** 2).sum(axis=-1)


@every_chain
def test_upright_is_highest_and_hanging_is_lowest(system: System) -> None:
    q, _ = states(system)
    potential = [system.potential(list(point), np) for point in q]
    assert system.potential(system.at_rest("upright"), np) > max(potential)
    assert system.potential(system.at_rest("hanging"), np) < min(potential)


@every_chain
def test_links_point_up_when_upright(system: System) -> None:
    states = (system.at_rest(name) for name in ("upright", "hanging"))
    up, down = (np.array(system.body_points(list(q), np)) for q in states)
    assert np.all(np.diff(up[:, 1]) > 0)
    assert np.all(np.diff(down[:, 1]) < 0)
    np.testing.assert_allclose(up[:, 0], 0, atol=1e-15)


@every_chain
def test_both_rest_positions_are_equilibria(system: System) -> None:
    rest = np.zeros(system.n_q)
    for q in (system.at_rest("upright"), system.at_rest("hanging")):
        acceleration = evaluate(dynamics_of(system).acceleration, q, rest, rest)
        np.testing.assert_allclose(acceleration, 0, atol=1e-14)


@every_chain
def test_body_points_move_as_the_coordinates_say(system: System) -> None:
    q, _ = states(system)
    points = np.array([system.body_points(list(point), np) for point in q])
    np.testing.assert_allclose(points[:, 0], np.c_[q[:, 0], 0 * q[:, 0]])
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    np.testing.assert_allclose(lengths, np.broadcast_to(lengths[0], lengths.shape))


def test_the_free_rod_is_the_second_link_of_the_double_pendulum() -> None:
    """Its energies, at the place of that link, are what the link adds to the cart and the first rod."""
    rod, double, single = load("rod"), load("dip"), load("sip_rod")
    q, qd = states(double)
    for point, rate in zip(q, qd, strict=True):
        ends, ahead, behind = (
            np.array(double.body_points(list(point + shift * rate), np))[1:] for shift in (0.0, 1e-6, -1e-6)
        )
        centre, velocity = ends.mean(axis=0), (ahead - behind).mean(axis=0) / 2e-6
        place, motion = [*centre, point[2]], [*velocity, rate[2]]
        added = double.kinetic(point, rate, np) - single.kinetic(point[:2], rate[:2], np)
        assert rod.kinetic(place, motion, np) == pytest.approx(added, rel=1e-7)
        assert rod.potential(place, np) == pytest.approx(
            double.potential(point, np) - single.potential(point[:2], np), abs=1e-12
        )
        np.testing.assert_allclose(rod.body_points(place, np), ends, atol=1e-12)


def test_the_link_is_a_stiffening_spring() -> None:
    system = load("link", damping=[0.3])
    acceleration = evaluate(dynamics_of(system).acceleration, np.array([0.2]), np.array([0.5]), np.array([1.0]))
    assert acceleration[0] == pytest.approx((1.0 - 0.3 * 0.5 - 20 * 0.2 - 40 * 0.2**3) / 0.5)
    assert np.linalg.norm(np.subtract(*system.body_points([0.2], np))) == pytest.approx(1.2)


def test_damping_may_grow_with_the_angle() -> None:
    system = load("sip", damping=[0.3, 0.02], damping_growth=2.0)
    level, upright = ([0.0, math.pi / 2], [0.0, 0.0])
    assert system.dissipation(upright, [1.0, 2.0], np) == pytest.approx(0.15 + 0.04)
    assert system.dissipation(level, [1.0, 2.0], np) == pytest.approx(0.15 + 0.12)
    with pytest.raises(UserError, match="damping_growth"):
        load("sip", damping_growth=-1.0)


def test_kinetic_energy_of_the_point_mass_is_that_of_its_points() -> None:
    system = load("sip")
    q, qd = states(system)
    speed_squared = speeds(system, q, qd)
    expected = 0.5 * speed_squared @ np.array([0.6, 0.2])
    np.testing.assert_allclose([system.kinetic(*pair, np) for pair in zip(q, qd, strict=True)], expected, rtol=1e-8)


@every_chain
def test_energies_of_rods_are_integrals_over_their_lengths(system: System) -> None:
    if system.name == "sip":
        pytest.skip("has no rod")
    q, qd = states(system)
    step = 1e-6
    at, ahead, behind = (
        np.array([system.body_points(list(point), np) for point in q + shift * qd]) for shift in (0, step, -step)
    )
    velocity = (ahead - behind) / (2 * step)
    nodes, weights = np.polynomial.legendre.leggauss(3)
    kinetic, potential = 0.5 * 0.6 * velocity[:, 0, 0] ** 2, 0.0
    for along, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
        speed = (1 - along) * velocity[:, :-1] + along * velocity[:, 1:]
        height = ((1 - along) * at[:, :-1] + along * at[:, 1:])[..., 1]
        kinetic = kinetic + 0.5 * 0.2 * weight * (speed**2).sum((1, 2))
        potential = potential + 0.2 * 9.8 * weight * height.sum(1)
    np.testing.assert_allclose([system.kinetic(*pair, np) for pair in zip(q, qd, strict=True)], kinetic, rtol=1e-8)
    np.testing.assert_allclose([system.potential(point, np) for point in q], potential, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize(("n", "name"), [(1, "sip_rod"), (2, "dip")])
@pytest.mark.parametrize("frame", ["relative", "absolute"])
def test_the_pendulum_of_one_and_two_links_is_the_single_and_the_double_one(n: int, name: str, frame: str) -> None:
    damping = [0.3, 0.01, 0.005][: n + 1]
    chain, known = (load(*which, damping_frame=frame, damping=damping, **more) for which, more in (
        (("cart_rods",), {"n": n}), ((name,), {}),
    ))  # fmt: skip
    q, qd = states(known)
    qdd = np.random.default_rng(3).uniform(-30, 30, q.shape)
    for function in ("inverse", "acceleration"):
        one, other = (evaluate(getattr(dynamics_of(s), function), q, qd, qdd) for s in (chain, known))
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-10)
    assert chain.coordinates == known.coordinates


def test_without_its_second_rod_the_double_pendulum_is_the_single_one() -> None:
    double, single = load("dip", m2=1e-12), load("sip_rod")
    q, qd = states(double)
    inverse = evaluate(dynamics_of(double).inverse, q, qd, qd)
    np.testing.assert_allclose(
        inverse[:, :2], evaluate(dynamics_of(single).inverse, q[:, :2], qd[:, :2], qd[:, :2]), rtol=0, atol=1e-9
    )


def test_the_printed_energies_of_the_double_pendulum_break_the_energy_balance() -> None:
    """Along the free motion of the bodies from (90, 90) deg over 10 s."""
    right, misprinted = load("dip"), load("dip", "printed")
    start = np.array([[0.0, np.pi / 2, np.pi / 2, 0.0, 0.0, 0.0]])
    states = simulate(dynamics_of(right).acceleration, start, np.zeros((1, 250, 3)), 0.04)[0]
    q, qd = states[:, :3], states[:, 3:]
    turned, turned_rates = np.pi - q * [-1.0, 1.0, 1.0] - [np.pi, 0.0, 0.0], qd * [1.0, -1.0, -1.0]
    drift = np.ptp(evaluate(dynamics_of(right).hamiltonian, q, qd))
    kinetic, potential = (
        evaluate(getattr(dynamics_of(misprinted), part), turned, turned_rates)[:, 0]
        for part in ("kinetic", "potential")
    )
    true_kinetic, true_potential = (
        evaluate(getattr(dynamics_of(right), part), q, qd)[:, 0] for part in ("kinetic", "potential")
    )
    assert drift < 1e-4
    assert np.ptp(kinetic + true_potential) > 0.2
    assert np.ptp(true_kinetic + potential) > 0.2


@pytest.mark.parametrize("n", [2, 5, 8])
def test_energy_balance_of_chains_at_every_step(n: int) -> None:
    system = load("cart_rods", n=n)
    random = np.random.default_rng(n)
    start = np.concatenate([random.uniform(-3, 3, (4, n + 1)), random.uniform(-1, 1, (4, n + 1))], axis=1)
    force = random.uniform(-4, 4, (4, 100, 1)) * np.eye(n + 1)[0]
    dynamics = dynamics_of(system)
    states = simulate(dynamics.acceleration, start, force, 0.04, angles=system.angles)
    energy = evaluate(dynamics.hamiltonian, states[..., : n + 1], states[..., n + 1 :])[..., 0]
    balance = np.diff(energy) - force[..., 0] * np.diff(states[..., 0])
    assert np.abs(balance).max() < 1e-4


@pytest.mark.parametrize("name", [name for name in READ if (name, "printed") != MISPRINTED])
def test_readings_are_equivalent_under_the_mirror_map(name: str) -> None:
    physical, printed = (load(name, reading) for reading in Reading)
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


@pytest.mark.parametrize("frame", ["relative", "absolute"])
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
    qd = [0.5, 2.0, -1.0]
    relative, absolute = (
        load("dip", damping=[1.0, 2.0, 3.0], damping_frame=frame).dissipation([0.0] * 3, qd, np)
        for frame in ("relative", "absolute")
    )
    matrix = np.array([[1.0, 0, 0], [0, 2.0 + 3.0, -3.0], [0, -3.0, 3.0]])
    assert relative == pytest.approx(0.5 * np.array(qd) @ matrix @ qd)
    assert absolute == pytest.approx(0.5 * (1.0 * 0.25 + 2.0 * 4.0 + 3.0 * 1.0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "tripod"}, "sip_rod"),
        ({"name": "sip", "reading": "literal"}, "printed"),
        ({"name": "sip", "damping_frame": "joint"}, "relative"),
        ({"name": "link", "reading": "printed"}, "system=link goes with reading = physical"),
        ({"name": "link", "damping_growth": 1.0}, "system=link goes with damping_growth = 0.0"),
        ({"name": "sip", "coulomb": [0.1]}, "coulomb of sip needs 2 non-negative"),
        ({"name": "sip", "damping": [0.1]}, "2 non-negative"),
        ({"name": "sip", "damping": [0.1, -0.1]}, r"damping.1 = -0.1: should be greater than or equal to 0"),
        ({"name": "sip", "damping": [0.1, math.nan]}, r"damping.1 = nan: should be a finite number"),
        ({"name": "sip", "M1": 0.1}, "m1"),
        ({"name": "sip", "m1": 0.0}, "m1 = 0.0 of sip: must be a positive number"),
        ({"name": "cart_rods", "n": 9}, "n = 9 of cart_rods: must be one of 1 to 8"),
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
        "coulomb": [0.0, 0.0],
        "damping_frame": "relative",
        "damping_growth": 0.0,
        "m0": 0.6,
        "m1": 0.2,
        "L1": 0.5,
        "g": 9.8,
    }
