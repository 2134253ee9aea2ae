"""The trap L = p_x^2 / (2 m) of the double pendulum: what most would do ends in it, the recommended recipe does not."""

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.evaluation.pointwise import pointwise
from repro.learning.objective import Objective
from repro.learning.optimisers.lbfgs import LBFGS
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.gauge import Gauge
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured

pytestmark = pytest.mark.slow
SEEDS = [20, 21]


@pytest.fixture(scope="module")
def double_pendulum():
    system = load("dip")
    options = {"episode_steps": 50, "reset": "random", "force_limit": 4.0}
    return system, random_force(system, seeds=SEEDS, samples=5000, train_samples=300, **options)


def _metrics(double_pendulum, model, optimiser, error_scale):
    system, data = double_pendulum
    parameters = torch.from_numpy(model.initial([np.random.default_rng([seed, 1]) for seed in SEEDS]))
    problem = TrainingProblem(model, [make_task(model, data.train, Objective(), error_scale=error_scale)], SEEDS)
    fitted = optimiser.fit(problem, parameters, silent, NoCheckpoint())
    return {m.name: m.values for m in pointwise(model, fitted.parameters, data.test, system, "test", Gauge.RAW)}


def test_a_network_for_the_cholesky_factor_ends_in_the_trap(double_pendulum):
    options = {"factor": "triangular", "initialisation": "glorot", "activation": "softplus", "skip": False}
    model = Structured(3, np.ones(3), structured.Options(hidden=(16, 16), **options))
    metrics = _metrics(double_pendulum, model, LBFGS(iterations=200), None)
    np.testing.assert_array_equal(metrics["trapped"], 1)


def test_a_wide_scaled_factor_weights_and_levenberg_marquardt_escape_it(double_pendulum):
    _, data = double_pendulum
    model = Structured(3, data.train.qd.reshape(-1, 3).std(axis=0), structured.Options(hidden=(8,)))
    optimiser = LevenbergMarquardt(iterations=60, samples=None, restarts=2, trial_iterations=20)
    metrics = _metrics(double_pendulum, model, optimiser, 20.0)
    np.testing.assert_array_equal(metrics["trapped"], 0)
    assert np.all(metrics["mae_tau"] < 0.01)
    assert np.all(metrics["mae_H_centred"] < 0.01)
    np.testing.assert_allclose(metrics["gravity"], 1, atol=0.02)
