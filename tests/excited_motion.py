"""Motions of a plant under random forces, and a model that is fitted before, as tests of identification use them."""

import casadi as ca
import numpy as np
from cart_task import random_start
from scipy.optimize import least_squares
from simulated import random_force

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate

DT = 0.005
PULL = 0.01


def motion(system, steps=25, seed=0):
    """Stretches (step, 9, 2 n_q) of the plant under random forces (step, 8, 1)."""
    applied = np.repeat(np.random.default_rng(seed).uniform(-4, 4, steps), 8)
    tau = applied[None, :, None] * np.eye(system.n_q)[0]
    start = random_start(system, 0.8, seed, 0).state
    states = simulate(dynamics_of(system).acceleration, start[None], tau, DT, angles=system.angles)[0]
    return np.stack([states[8 * k : 8 * k + 9] for k in range(steps)]), applied.reshape(steps, 8, 1)


def training(system):
    data = random_force(
        system, seeds=[0], regime="episodes", episode_steps=50, samples=1000, train_fraction=0.8, time_step=0.04,
        force_limit=4.0, start="upright", reset="random", labels="exact", tau_noise=0.0, qdd_noise=0.0, q_noise=0.0,
        qd_noise=0.0, common=False,
    )  # fmt: skip
    return data.q[0], data.qd[0], data.qdd[0]


def fitted(model, samples, tau, seed=0):
    """Weights of least squares on the forces, by Levenberg-Marquardt.

    Directions that no force depends on: a slight pull to the start makes the weights of a network follow from the data.
    """
    q, qd, qdd, w = (
        ca.SX.sym(name, size) for name, size in (("q", 2), ("qd", 2), ("qdd", 2), ("w", model.n_parameters))
    )
    said = model.inverse_dynamics(q, qd, qdd, w)
    value, slope = (ca.Function("f", [q, qd, qdd, w], [ca.densify(e)]) for e in (said, ca.jacobian(said, w)))
    start = model.initial([np.random.default_rng(seed)])[0]
    pull = PULL * np.eye(len(start))
    found = least_squares(
        lambda w: np.append(evaluate(value, *samples, w) - tau, pull @ (w - start)),
        start,
        lambda w: np.vstack([evaluate(slope, *samples, w).reshape(tau.size, -1), pull]),
        method="lm",
        max_nfev=200,
    )
    assert np.abs(found.fun).max() < 0.1
    return found.x
