from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from repro.codegen import c_library
from repro.codegen.array_evaluation import evaluate
from repro.codegen.straight_line import PART
from repro.errors import UserError
from repro.mechanics import integrators
from repro.mechanics import simulate as engines
from repro.mechanics.derive import dynamics_of
from repro.mechanics.integrators import ANGLE, MOST
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.simulate import simulate
from repro.mechanics.system import load

both_engines = pytest.mark.parametrize("engine", ["c", "casadi"])
SYSTEM = load("sip")
PENDULUM = dynamics_of(SYSTEM)


def random_tau(members: int, steps: int) -> np.ndarray:
    force = np.stack([np.random.default_rng(seed).uniform(-5, 5, (steps, 1)) for seed in range(members)])
    return force @ np.eye(SYSTEM.n_q)[:1]


def upright(members: int) -> np.ndarray:
    return np.tile(np.concatenate([SYSTEM.at_rest("upright"), np.zeros(2)]), (members, 1))


def one_coordinate(acceleration) -> ca.Function:
    q, qd, tau, parameters = ca.SX.sym("q"), ca.SX.sym("qd"), ca.SX.sym("tau"), ca.SX.sym("p", 2)
    return ca.Function("one", [q, qd, tau, parameters], [acceleration(q, qd, tau, parameters)])


def test_long_random_motion_balances_its_energy() -> None:
    """H[k+1] - H[k] = f[k] (x[k+1] - x[k]) to 1e-4 J at every step of 100,000, up to 100 rad/s."""
    tau = random_tau(6, 100_000)
    x = simulate(PENDULUM.acceleration, upright(6), tau, 0.04, angles=SYSTEM.angles, engine="c")
    energy = evaluate(PENDULUM.hamiltonian, x[..., :2], x[..., 2:])[..., 0]
    work = tau[..., 0] * np.diff(x[..., 0], axis=1)
    assert np.abs(x[..., 3]).max() > 60
    assert np.abs(np.diff(energy, axis=1) - work).max() < 1e-4


@both_engines
def test_energy_is_balanced_at_a_hundred_turns_a_step(engine: str) -> None:
    start = np.array([[0.0, 0.3, 1.0, 100.0]])
    tau = random_tau(1, 200)
    x = simulate(PENDULUM.acceleration, start, tau, 0.04, engine=engine)
    energy = evaluate(PENDULUM.hamiltonian, x[..., :2], x[..., 2:])[..., 0]
    assert np.abs(np.diff(energy) - tau[..., 0] * np.diff(x[..., 0])).max() < 1e-4


@both_engines
def test_runge_kutta_is_of_fourth_order(engine: str) -> None:
    start, tau = np.array([[0.0, 2.0, 0.5, 3.0]]), random_tau(1, 25)

    def end(substeps: int) -> np.ndarray:
        return simulate(PENDULUM.acceleration, start, tau, 0.04, substeps=substeps, engine=engine)[0, -1]

    exact = end(1280)
    counts = np.array([16, 32, 64])
    errors = [np.abs(end(count) - exact).max() for count in counts]
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert -slope == pytest.approx(4, abs=0.1)


def test_free_oscillator_follows_its_closed_form() -> None:
    oscillator = one_coordinate(lambda q, qd, tau, p: -p[0] * q + p[1] * tau)
    start, step = np.array([[1.0, 0.0]]), 0.1
    x = simulate(oscillator, start, np.zeros((1, 100, 1)), step, parameters=np.array([4.0, 1.0]), substeps=20)[0]
    t = step * np.arange(101)
    np.testing.assert_allclose(x, np.stack([np.cos(2 * t), -2 * np.sin(2 * t)], axis=-1), atol=1e-7)


@both_engines
def test_force_is_held_over_each_step(engine: str) -> None:
    integrator = one_coordinate(lambda q, qd, tau, p: tau + 0 * p[0])
    tau = np.array([1.0, -2.0, 0.5]).reshape(1, 3, 1)
    x = simulate(integrator, np.zeros((1, 2)), tau, 0.5, parameters=np.zeros(2), engine=engine)[0]
    np.testing.assert_allclose(x[:, 1], [0, 0.5, -0.5, -0.25], atol=1e-15)
    np.testing.assert_allclose(x[:, 0], [0, 0.125, 0.125, -0.0625], atol=1e-15)


def test_engines_agree_to_the_last_digits() -> None:
    tau, start = random_tau(3, 300), upright(3)
    start[:, 3] = 20.0
    one, other = (simulate(PENDULUM.acceleration, start, tau, 0.04, engine=engine) for engine in ("c", "casadi"))
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)


def test_the_cheaper_engine_interprets_first_and_changes_to_compiled_code_in_time(monkeypatch) -> None:
    used = []
    engines.active_engine()  # which compiles something to find out
    monkeypatch.setattr(engines, "COMPILATION_S", 600 * engines.STEP_S)
    for name in ("CompiledIntegrator", "InterpretedIntegrator"):
        made = getattr(engines, name)
        monkeypatch.setattr(engines, name, lambda *given, made=made, name=name: used.append(name) or made(*given))
    motion = one_coordinate(lambda q, qd, tau, p: tau - p[0] * ca.sin(q) - p[1] * qd)
    tau, weights = random_tau(1, 200)[..., :1], np.array([9.0, 0.1])
    pieces = [simulate(motion, np.ones((1, 2)), tau, 0.04, parameters=weights, engine="cheaper") for _ in range(4)]
    assert used == ["InterpretedIntegrator", "CompiledIntegrator"]
    expected = simulate(motion, np.ones((1, 2)), tau, 0.04, parameters=weights, engine="casadi")
    for piece in pieces:
        np.testing.assert_allclose(piece, expected, rtol=1e-12)


def test_batch_mates_do_not_matter() -> None:
    tau = random_tau(4, 100)
    start = upright(4)
    start[:, 3] = [0, 5, 50, np.nan]
    together = simulate(PENDULUM.acceleration, start, tau, 0.04)
    for member in range(4):
        alone = simulate(PENDULUM.acceleration, start[member : member + 1], tau[member : member + 1], 0.04)
        np.testing.assert_array_equal(alone[0], together[member])


def translated() -> list[tuple[str, ca.Function]]:
    """One function an operation, that the operation's operands reach."""
    q, qd, tau, p = ca.SX.sym("q"), ca.SX.sym("qd"), ca.SX.sym("tau"), ca.SX.sym("p", 2)
    a, b = q, p[0]
    expressions = {
        "arithmetic": (a + b) * (a - b) / (1 + b * b) - a,
        "powers": ca.fabs(a) ** 1.7 + ca.fabs(a) ** b + a**3 + 2**a + 1 / (2 + a * a) + 2 * a,
        "exponentials": ca.exp(-a) + ca.expm1(a) + ca.log(2 + a * a) + ca.log1p(a * a) + ca.sqrt(1 + a * a),
        "trigonometry": ca.sin(a) + ca.cos(a) + ca.tan(a / 9) + ca.atan(a) + ca.atan2(a, b),
        "hyperbolas": ca.tanh(a) + ca.sinh(a) + ca.cosh(a),
        "softplus": ca.log1p(ca.exp(-ca.fabs(a))) + ca.fmax(a, 0),
        "extremes": ca.fmin(a, b) + ca.fmax(a, p[1]) + ca.sign(a) + ca.sign(a - a),
        "cases": ca.if_else(a > b, a, b) + ca.if_else(ca.logic_or(a <= b, a == 1), 1, 2),
        "logic": ca.if_else(ca.logic_and(a < 1, ca.logic_not(a != b)), 3, 4) + ca.logic_not(a),
        "constants": a + ca.pi + 1e-300 + 0.1,
    }
    return [(name, ca.Function(name, [q, qd, tau, p], [expression])) for name, expression in expressions.items()]


@both_engines
@pytest.mark.parametrize(("name", "function"), translated(), ids=[name for name, _ in translated()])
def test_every_operation_is_what_casadi_means(engine: str, name: str, function: ca.Function) -> None:
    """One sub-step of RK4, with the accelerations evaluated by CasADi."""
    starts = np.array([[-1.3, 0.2], [0.0, 0.0], [0.7, -0.4], [1.0, 1.0], [2.5, 0.1]])
    parameters = np.array([0.7, -0.2])

    def derivative(x: np.ndarray) -> np.ndarray:
        acceleration = evaluate(function, x[:, :1], x[:, 1:], np.zeros(1), parameters)
        return np.concatenate([x[:, 1:], acceleration], axis=1)

    h = 0.01
    expected = rk4_step(derivative, starts, h)
    x = simulate(function, starts, np.zeros((5, 1, 1)), h, substeps=1, parameters=parameters, engine=engine)
    np.testing.assert_allclose(x[:, 1], expected, rtol=1e-12, atol=1e-13)


def test_an_operation_without_a_translation_to_c_is_named() -> None:
    function = one_coordinate(lambda q, qd, tau, p: ca.erf(q) + tau)
    with pytest.raises(ValueError, match="'erf' of one"):
        simulate(function, np.zeros((1, 2)), np.zeros((1, 1, 1)), 0.1, parameters=np.zeros(2), engine="c")


@both_engines
def test_large_functions_are_divided_and_still_right(engine: str) -> None:
    def network(q, qd, tau, p):
        return sum(ca.tanh(q * (k + 1) + p[0]) / (k + 1) for k in range(PART)) * p[1] + tau

    function = one_coordinate(network)
    assert function.n_instructions() > 3 * PART
    x = simulate(function, np.array([[0.3, 0.0]]), np.ones((1, 3, 1)), 0.01, parameters=np.ones(2), engine=engine)
    reference = simulate(function, np.array([[0.3, 0.0]]), np.ones((1, 3, 1)), 0.01, parameters=np.ones((1, 2)))
    np.testing.assert_allclose(x, reference, rtol=1e-12)
    rate = evaluate(function, np.array([0.3]), np.zeros(1), np.ones(1), np.ones(2))[0]
    assert x[0, 1, 1] == pytest.approx(0.01 * rate, rel=0.05)


@both_engines
def test_every_trajectory_can_have_its_own_parameters(engine: str) -> None:
    oscillator = one_coordinate(lambda q, qd, tau, p: -p[0] * q + p[1])
    weights = np.array([[1.0, 0.0], [4.0, 1.0]])
    start = np.array([[1.0, 0.0], [1.0, 0.0]])
    both = simulate(oscillator, start, np.zeros((2, 30, 1)), 0.1, parameters=weights, engine=engine)
    for member in range(2):
        own = simulate(oscillator, start[:1], np.zeros((1, 30, 1)), 0.1, parameters=weights[member], engine=engine)
        np.testing.assert_array_equal(own[0], both[member])


@both_engines
def test_a_trajectory_that_blows_up_is_not_a_number_from_there_on(engine: str) -> None:
    explosion = one_coordinate(lambda q, qd, tau, p: p[0] * q**3 + tau)
    start = np.array([[2.0, 0.0], [1e-3, 0.0]])
    x = simulate(
        explosion, start, np.zeros((2, 300, 1)), 0.05, angles=[], parameters=np.array([1.0, 0.0]), engine=engine
    )
    blown = np.isnan(x[0]).all(axis=-1)
    first = int(np.argmax(blown))
    assert 0 < first < 300
    assert blown[first:].all()
    assert np.isfinite(x[0, :first]).all()
    assert np.isfinite(x[1]).all()


@both_engines
def test_a_runaway_is_given_up_at_once(engine: str) -> None:
    runaway = one_coordinate(lambda q, qd, tau, p: 1e9 + tau)
    x = simulate(runaway, np.zeros((1, 2)), np.zeros((1, 100_000, 1)), 0.04, parameters=np.zeros(2), engine=engine)
    assert np.isfinite(x[0, :2]).all()
    assert np.isnan(x[0, 2:]).all()
    assert abs(x[0, 1, 1]) * 0.04 > MOST * ANGLE


@both_engines
def test_a_start_beyond_all_rates_is_given_up(engine: str) -> None:
    free = one_coordinate(lambda q, qd, tau, p: tau + 0 * p[0])
    start = np.array([[0.0, 1e200], [np.inf, 0.0], [0.0, np.nan]])
    x = simulate(free, start, np.zeros((3, 4, 1)), 0.04, parameters=np.zeros(2), engine=engine)
    np.testing.assert_array_equal(x[:, 0], start)
    assert np.isnan(x[:, 1:]).all()


def test_no_steps_and_no_trajectories_are_fine() -> None:
    assert simulate(PENDULUM.acceleration, upright(2), np.zeros((2, 0, 2)), 0.04).shape == (2, 1, 4)
    assert simulate(PENDULUM.acceleration, upright(0), np.zeros((0, 5, 2)), 0.04).shape == (0, 6, 4)


@pytest.mark.parametrize(
    "wrong",
    [
        {"initial": np.zeros((1, 3))},
        {"u": np.zeros((1, 5, 1))},
        {"u": np.zeros((2, 5, 2))},
        {"parameters": np.zeros(3)},
        {"substeps": 0},
    ],
)
def test_shapes_that_do_not_fit_are_refused(wrong: dict) -> None:
    arguments = {"initial": np.zeros((1, 4)), "u": np.zeros((1, 5, 2)), "time_step": 0.04} | wrong
    with pytest.raises(ValueError, match="got"):
        simulate(PENDULUM.acceleration, **arguments)


def test_unknown_engines_are_refused() -> None:
    with pytest.raises(UserError, match="auto, cheaper, c, casadi"):
        simulate(PENDULUM.acceleration, upright(1), np.zeros((1, 1, 2)), 0.04, engine="fortran")


@pytest.fixture
def no_compiler(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    for cached in (c_library.found_compiler, engines.active_engine, engines.compiled):
        cached.cache_clear()
    monkeypatch.setattr(c_library.shutil, "which", lambda name: None)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    yield
    for cached in (c_library.found_compiler, engines.active_engine, engines.compiled):
        cached.cache_clear()


@pytest.mark.usefixtures("no_compiler")
def test_without_a_compiler_casadi_takes_over_with_one_notice(caplog: pytest.LogCaptureFixture) -> None:
    for _ in range(2):
        x = simulate(PENDULUM.acceleration, upright(1), random_tau(1, 3), 0.04)
    assert np.isfinite(x).all()
    assert engines.active_engine() == "casadi"
    assert [record.message.split(":")[0] for record in caplog.records] == [c_library.NO_COMPILER]
    with pytest.raises(UserError, match="no C compiler"):
        simulate(PENDULUM.acceleration, upright(1), random_tau(1, 3), 0.04, engine="c")


def test_compiled_code_is_kept_and_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    integrators.CompiledIntegrator(["qdd[0] = 2.0 * u[0]"], 0, 1, 1)
    (library,) = (tmp_path / "repro").iterdir()
    made = library.stat().st_mtime_ns
    integrators.CompiledIntegrator(["qdd[0] = 2.0 * u[0]"], 0, 1, 1)
    assert [(path, path.stat().st_mtime_ns) for path in (tmp_path / "repro").iterdir()] == [(library, made)]


@pytest.mark.parametrize("links", [1, 2, 3])
def test_a_step_lasts_as_long_as_it_says_for_any_number_of_links(links: int) -> None:
    """At constant speed on the cart alone the distance is speed times time, whatever the number of sub-steps."""
    system = load("cart_rods", n=links)
    start = np.concatenate([system.at_rest("hanging"), np.eye(links + 1)[0]])[None]
    states = simulate(dynamics_of(system).acceleration, start, np.zeros((1, 10, links + 1)), 0.04, angles=system.angles)
    np.testing.assert_allclose(states[0, :, 0], 0.04 * np.arange(11), atol=1e-12)
