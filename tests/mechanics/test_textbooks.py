"""Equations of motion typed from the literature, against those derived from T and V."""

import numpy as np
import pytest

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import generalised_force
from repro.mechanics.system import System, load

G = 9.8


def sampled(system: System) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, qd (40, n_q) and u (40, n_u) at random."""
    random = np.random.default_rng(11)
    n_u = len(system.inputs)
    return (
        random.uniform(-3, 3, (40, system.n_q)),
        random.uniform(-5, 5, (40, system.n_q)),
        random.normal(size=(40, n_u)),
    )


def acceleration(system: System, q: np.ndarray, qd: np.ndarray, u: np.ndarray) -> np.ndarray:
    return evaluate(dynamics_of(system).acceleration, q, qd, generalised_force(system, q, u))


@pytest.mark.parametrize(("name", "driven"), [("acrobot", 1), ("pendubot", 0)])
def test_acrobot_and_pendubot_of_spong(name: str, driven: int) -> None:
    """Spong, The swing up control problem for the acrobot, IEEE Control Systems 15(1), 1995, eqs. (1) and (2).

    d11 q1dd + d12 q2dd + h1 + phi1 = 0, d12 q1dd + d22 q2dd + h2 + phi2 = tau, with the d, h and phi listed below
    them; in the pendubot the torque stands in the first. q1 is measured from level, counter-clockwise, and q2 from the
    first link.
    """
    m1, m2, l1, lc1, lc2 = 0.2, 0.3, 0.5, 0.25, 0.2
    i1, i2 = m1 * l1**2 / 12, m2 * (2 * lc2) ** 2 / 12
    system = load(name, m1=m1, m2=m2, L1=l1, L2=2 * lc2)
    q, qd, u = sampled(system)
    q1, q2 = np.pi / 2 - q[:, 0], q[:, 0] - q[:, 1]
    q1d, q2d = -qd[:, 0], qd[:, 0] - qd[:, 1]
    d11 = m1 * lc1**2 + m2 * (l1**2 + lc2**2 + 2 * l1 * lc2 * np.cos(q2)) + i1 + i2
    d22 = np.full_like(q2, m2 * lc2**2 + i2)
    d12 = m2 * (lc2**2 + l1 * lc2 * np.cos(q2)) + i2
    h1 = -m2 * l1 * lc2 * np.sin(q2) * q2d**2 - 2 * m2 * l1 * lc2 * np.sin(q2) * q2d * q1d
    h2 = m2 * l1 * lc2 * np.sin(q2) * q1d**2
    phi1 = (m1 * lc1 + m2 * l1) * G * np.cos(q1) + m2 * lc2 * G * np.cos(q1 + q2)
    phi2 = m2 * lc2 * G * np.cos(q1 + q2)
    torque = np.zeros((40, 2))
    torque[:, driven] = -u[:, 0]  # clockwise here, counter-clockwise there
    mass = np.stack([np.stack([d11, d12], -1), np.stack([d12, d22], -1)], -2)
    solved = np.linalg.solve(mass, (torque - np.stack([h1 + phi1, h2 + phi2], -1))[..., None])[..., 0]
    expected = np.stack([-solved[:, 0], -solved[:, 0] - solved[:, 1]], axis=-1)
    np.testing.assert_allclose(acceleration(system, q, qd, u), expected, rtol=1e-10, atol=1e-10)


def test_furuta_pendulum_of_cazzolato_and_prime() -> None:
    """Cazzolato and Prime, On the dynamics of the Furuta pendulum, J. Control Sci. Eng. 2011, 528341, eqs. (33), (34).

    These are the accelerations for a slender pendulum without inertia about its own axis, here without friction and
    torque on the pendulum. Theirs hangs at theta2 = 0 and turns the other way round.
    """
    j1, l1, m2, length = 0.02, 0.25, 0.2, 0.5
    l2, j2 = length / 2, m2 * length**2 / 3
    j0, moment = j1 + m2 * l1**2, m2 * l1 * l2
    system = load("furuta", J0=j1, r=l1, m1=m2, L1=length)
    q, qd, u = sampled(system)
    theta2, t1d, t2d, torque = np.pi - q[:, 1], qd[:, 0], -qd[:, 1], u[:, 0]
    s, c, s2 = np.sin(theta2), np.cos(theta2), np.sin(2 * theta2)
    inner = j0 + j2 * s**2
    both = j0 * j2 + j2**2 * s**2 - moment**2 * c**2
    t1dd = (
        -(j2**2) * s2 * t1d * t2d
        - moment * j2 * c * s2 * t1d**2 / 2
        + moment * j2 * s * t2d**2
        + j2 * torque
        + m2**2 * l2**2 * l1 * s2 * G / 2
    ) / both
    t2dd = (
        moment * j2 * c * s2 * t1d * t2d
        + s2 * inner * j2 * t1d**2 / 2
        - moment**2 * s2 * t2d**2 / 2
        - moment * c * torque
        - m2 * l2 * s * inner * G
    ) / both
    np.testing.assert_allclose(acceleration(system, q, qd, u), np.stack([t1dd, -t2dd], -1), rtol=1e-10, atol=1e-10)


def test_planar_quadrotor_of_tedrake() -> None:
    """Tedrake, Underactuated Robotics (course notes, MIT, 2023), chapter 3, "The Planar Quadrotor".

    m xdd = -(u1 + u2) sin(theta), m ydd = (u1 + u2) cos(theta) - m g, I thetadd = r (u1 - u2); his u1 is the right one.
    """
    m, inertia, r = 0.5, 0.01, 0.2
    system = load("quadrotor")
    q, qd, u = sampled(system)
    theta, both = q[:, 2], u.sum(-1)
    expected = np.stack(
        [-both * np.sin(theta) / m, both * np.cos(theta) / m - G, r * (u[:, 1] - u[:, 0]) / inertia], axis=-1
    )
    np.testing.assert_allclose(acceleration(system, q, qd, u), expected, rtol=1e-10, atol=1e-10)
