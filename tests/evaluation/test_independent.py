"""The anchors from scratch, by numpy and sympy alone: no mechanics, data or model of the project takes part.

Plants, simulation and regression are written a second time here. The project's numbers for the same quantities are in
the tables of regimes, energies and identifiability.
"""

import numpy as np
import pytest
import sympy as sp

STEP, SUBSTEPS, GRAVITY = 0.04, 5, 9.8


def single(state, force):
    """Accelerations of the cart with a point mass, theta = 0 up: M = [[0.8, 0.1 c], [0.1 c, 0.05]], V = 0.98 c."""
    c, s, rate = np.cos(state[1]), np.sin(state[1]), state[3]
    push, turn = force + 0.1 * s * rate**2, 0.98 * s
    determinant = 0.04 - 0.01 * c**2
    return np.array([(0.05 * push - 0.1 * c * turn) / determinant, (0.8 * turn - 0.1 * c * push) / determinant])


def simulated(accelerations, start, forces):
    """States (step + 1, 2 n_q, lane) by the classical Runge-Kutta rule under forces (step, lane) held over a step."""
    half, h = len(start) // 2, STEP / SUBSTEPS

    def slope(x, f):
        return np.concatenate([x[half:], accelerations(x, f)])

    states = [start]
    for force in forces:
        x = states[-1]
        for _ in range(SUBSTEPS):
            a = slope(x, force)
            b = slope(x + h / 2 * a, force)
            c = slope(x + h / 2 * b, force)
            x = x + h / 6 * (a + 2 * b + 2 * c + slope(x + h * c, force))
        states.append(x)
    return np.array(states)


@pytest.fixture(scope="module", params=[100, 1000])
def episodes(request):
    """Episodes of one length from upright under U(-5, 5): states (sample, 4), accelerations, forces (sample,)."""
    forces = np.random.default_rng(0).uniform(-5, 5, (request.param, 40))
    states = simulated(single, np.zeros((4, 40)), forces)[:-1]
    x = np.moveaxis(states, 1, 0).reshape(4, -1)
    return request.param, x, single(x, forces.ravel()), forces.ravel()


def test_the_closed_form_on_t1_is_exact(episodes):
    """L = a xd^2 + b thd^2 + c xd thd cos(theta) - d cos(theta) with 0.4, 0.025, 0.1 and 0.98."""
    _, x, acceleration, force = episodes
    c, s, zero = np.cos(x[1]), np.sin(x[1]), 0 * x[0]
    columns = [
        (2 * acceleration[0], zero),
        (zero, 2 * acceleration[1]),
        (acceleration[1] * c - x[3] ** 2 * s, acceleration[0] * c),
        (zero, -s),
    ]
    design = np.stack([np.concatenate(column) for column in columns], axis=1)
    measured = np.concatenate([force, zero])
    weights, *_ = np.linalg.lstsq(design, measured, rcond=None)
    np.testing.assert_allclose(weights, [0.4, 0.025, 0.1, 0.98], atol=1e-12)
    assert np.abs(design @ weights - measured).mean() < 1e-13


def test_the_degenerate_and_the_trivial_model_of_the_single_pendulum(episodes):
    """L = p^2 / 1.6 with p = 0.8 xd + 0.1 thd cos(theta) has tau = [f, f cos(theta) / 8]."""
    steps, x, _, force = episodes
    degenerate = np.abs(force * np.cos(x[1]) / 8).mean() / 2
    assert degenerate == pytest.approx({100: 0.1045, 1000: 0.0961}[steps], rel=0.05)
    assert np.abs(force).mean() / 2 == pytest.approx(1.25, rel=0.02)


def test_nearly_half_of_all_perfect_models_have_the_printed_errors_of_one_step():
    """The error of one explicit Euler step over 300 points, 400 seeds: what Fig. 4 shows says nothing of a model."""
    forces = np.random.default_rng(1).uniform(-5, 5, (300, 400))
    states = simulated(single, np.zeros((4, 400)), forces)
    steps = np.array([x[2:] + STEP * single(x, f) for x, f in zip(states[:-1], forces, strict=True)])
    errors = np.abs(steps - states[1:, 2:]).mean(0)
    np.testing.assert_allclose(np.median(errors, axis=1), [0.0305, 0.0784], rtol=0.1)
    printed = np.array([[0.05], [0.12]])
    both = np.all((errors > printed / 1.7) & (errors < printed * 1.7), axis=0)
    assert both.mean() == pytest.approx(0.47, abs=0.1)


@pytest.fixture(scope="module")
def double():
    """Accelerations of the double pendulum, and of every term of F (x) F and of V its forces and its energy."""
    q, v, a = (sp.symbols(f"{name}0:3") for name in "qva")
    mass, length = (0.6, 0.2, 0.2), 0.5
    x, y, kinetic, potential = q[0], sp.Integer(0), sp.Rational(1, 2) * mass[0] * v[0] ** 2, sp.Integer(0)

    def rate(term):
        return sum(sp.diff(term, p) * r for p, r in zip(q, v, strict=True))

    for link in (1, 2):
        half = length / 2
        centre = (x + half * sp.sin(q[link]), y + half * sp.cos(q[link]))
        kinetic += mass[link] * (rate(centre[0]) ** 2 + rate(centre[1]) ** 2) / 2
        kinetic += mass[link] * half**2 / 3 * v[link] ** 2 / 2
        potential += mass[link] * GRAVITY * centre[1]
        x, y = x + length * sp.sin(q[link]), y + length * sp.cos(q[link])

    def forces(lagrangian):
        momenta = [sp.diff(lagrangian, r) for r in v]
        return [
            sum(sp.diff(p, r) * s for r, s in zip(v, a, strict=True)) + rate(p) - sp.diff(lagrangian, c)
            for p, c in zip(momenta, q, strict=True)
        ]

    equations = forces(kinetic - potential)
    matrix = sp.Matrix([[sp.diff(e, s) for s in a] for e in equations])
    bias = sp.Matrix([e.subs(dict.fromkeys(a, 0)) for e in equations])
    motion = sp.lambdify([q, v], [matrix.tolist(), list(bias)], "numpy", cse=True)
    factors = [v[0], *(v[i] * g for i in (1, 2) for g in (sp.sin(q[i]), sp.cos(q[i]), sp.Integer(1)))]
    terms = [factors[i] * factors[j] for i in range(7) for j in range(i, 7)]
    columns = [*terms, *(-sp.cos(q[i]) for i in (1, 2))]
    energies = [*terms, *(sp.cos(q[i]) for i in (1, 2))]
    rows = sp.lambdify([q, v, a], [[forces(term) for term in columns], energies], "numpy", cse=True)

    def accelerations(state, force):
        lanes = state.shape[1]
        full, free = motion(state[:3], state[3:])
        matrices = np.array([[np.broadcast_to(e, lanes) for e in row] for row in full]).transpose(2, 0, 1)
        right = -np.array([np.broadcast_to(e, lanes) for e in free]).T
        right[:, 0] += force
        return np.linalg.solve(matrices, right[..., None])[..., 0].T

    return accelerations, rows


def regression(rows, states, accelerations):
    """Rows of tau and of H = T + V in the 30 coefficients."""
    samples = states.shape[1]
    tau, energy = rows(states[:3], states[3:], accelerations)
    broadcast = np.array([[np.broadcast_to(e, samples) for e in term] for term in tau])
    energy = np.array([np.broadcast_to(e, samples) for e in energy])
    return broadcast.reshape(len(tau), -1).T, energy.T


def rank(matrix):
    scaled = matrix / np.linalg.norm(matrix, axis=0)
    values = np.linalg.svd(scaled, compute_uv=False)
    return int(np.sum(values > 1e-9 * values[0]))


@pytest.mark.slow
def test_the_ranks_of_the_double_pendulum(double):
    """Of 30 coefficients D_H shows 26 by its forces and 27 with its energies; D shows 28, and so do both."""
    motion, rows = double
    rng = np.random.default_rng(2)
    angles = rng.uniform(-np.pi, np.pi, (2, 60))
    rest = np.concatenate([np.zeros((1, 60)), angles, np.zeros((3, 60))])
    free = simulated(motion, rest, np.zeros((10, 60)))
    free = np.moveaxis(free, 1, 0).reshape(6, -1)
    tau_h, energy_h = regression(rows, free, motion(free, 0.0))
    states = np.concatenate([rng.uniform(-np.pi, np.pi, (3, 400)), rng.uniform(-3, 3, (3, 400))])
    tau, _ = regression(rows, states, motion(states, rng.uniform(-4, 4, 400)))
    assert rank(tau_h) == 26
    assert rank(np.concatenate([tau_h, energy_h])) == 27
    assert rank(tau) == 28
    assert rank(np.concatenate([tau, tau_h, energy_h])) == 28
