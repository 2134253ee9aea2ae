"""States that are predicted over several samples: nothing remains of a model's own motion, and budgets end fits."""

import time
from dataclasses import replace

import numpy as np
import pytest
import torch
from simulated import random_force
from tensors import assert_close

from repro.evaluation.model_motion import model_motion
from repro.learning.objective import Objective
from repro.learning.objectives import mixed, prediction
from repro.learning.objectives.prediction import prediction_task
from repro.learning.optimisers.adam import Adam
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.kinds import blackbox, structured, symoden
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.structured import Structured
from repro.models.kinds.symoden import SymODEN
from repro.models.position import cart_with_links

SIP = load("sip")


@pytest.fixture
def data():
    return random_force(SIP, seeds=(0, 1), samples=120, reset="random", episode_steps=12, train_fraction=0.5)


@pytest.mark.parametrize(
    ("scheme", "substeps", "tolerance"), [("rk4", 1, 1e-4), ("rk4", 4, 1e-6), ("midpoint", 1, 3e-2)]
)
@pytest.mark.parametrize(
    "model", [BlackBox(2, blackbox.Options(hidden=(6,))), SymODEN(2, cart_with_links(2), symoden.Options(hidden=(4,)))]
)
def test_nothing_remains_of_the_own_motion_of_a_model(data, model, scheme, substeps, tolerance):
    weights = 0.5 * model.initial([np.random.default_rng(k) for k in range(2)])
    starts = np.concatenate([data.q, data.qd], axis=-1)[:, ::12]
    held = data.tau.reshape(2, 10, 12, 2)[:, :, :-1]
    motion = model_motion(model, weights, starts, held, data.time_step, ())
    q, qd = np.split(motion.reshape(2, 120, 4), 2, axis=-1)
    own = replace(data, q=q.copy(), qd=qd.copy())
    options = prediction.Options(scheme=scheme, substeps=substeps, intervals=3)
    task = prediction_task(model, own, Objective(options), options)
    assert task.samples == 10 * 3  # windows: eleven intervals an episode
    problem = TrainingProblem(model, [task], (0, 1))
    left = problem.loss(torch.from_numpy(weights)).sqrt()
    assert (left < tolerance * problem.loss(torch.zeros(weights.shape, dtype=torch.float64)).sqrt()).all()
    index = torch.arange(5).repeat(2, 1)
    assert problem.loss(torch.from_numpy(weights), index).shape == (2,)


@pytest.mark.parametrize("scheme", ["rk4", "midpoint"])
def test_uneven_samples_are_predicted_at_their_own_times(data, scheme):
    """Without acceleration positions are linear in time, whichever the stamps are."""
    stamps = data.time + 0.3 * data.time_step * np.sin(np.arange(len(data.time)) ** 2)
    speed = np.broadcast_to(data.qd[:, :1], data.qd.shape)
    drifting = replace(data, q=speed * stamps[:, None], qd=speed.copy(), time=stamps)
    model, options = BlackBox(2, blackbox.Options(hidden=(3,))), prediction.Options(scheme=scheme, intervals=4)
    problem = TrainingProblem(model, [prediction_task(model, drifting, Objective(options), options)], (0, 1))
    weights = torch.zeros(2, model.n_parameters, dtype=torch.float64)
    assert_close(problem.loss(weights), torch.zeros(2, dtype=torch.float64), atol=1e-20)


def test_the_gradient_reaches_through_all_intervals(data):
    model = BlackBox(2, blackbox.Options(hidden=(4,)))
    options = prediction.Options(intervals=5)
    problem = TrainingProblem(model, [options.task(model, data, Objective(options))], (0, 1))
    weights = torch.from_numpy(model.initial([np.random.default_rng(k) for k in range(2)])).requires_grad_()
    (gradient,) = torch.autograd.grad(problem.loss(weights).sum(), weights)
    direction = torch.from_numpy(np.random.default_rng(3).standard_normal(weights.shape))
    with torch.no_grad():
        ahead, behind = (problem.loss(weights + s * direction) for s in (1e-6, -1e-6))
    assert_close((gradient * direction).sum(1), (ahead - behind) / 2e-6, rtol=1e-5, atol=1e-8)


def test_the_power_of_the_mixed_rows_is_that_of_the_force(data):
    model = Structured(2, np.ones(2), structured.Options(hidden=(3,)))
    task = make_task(model, data, Objective(mixed.Options(power_weight=4.0, forward_weight=0.0)))
    weights = torch.from_numpy(model.initial([np.random.default_rng(k) for k in range(2)]))
    rows = task.residuals(model, weights)
    assert_close(rows[..., 4], 2 * (rows[..., :2] * task.measured["qd"]).sum(-1))
    assert not rows[..., 2:4].any()


@pytest.mark.parametrize("engine", ["auto", "torch"])
def test_a_fit_ends_with_its_budget_and_its_rate_falls_along_it(data, engine):
    model = BlackBox(2, blackbox.Options(hidden=(30, 30)))
    problem = TrainingProblem(model, [make_task(model, data, Objective(mixed.forward.Options()))], (0, 1))
    start = torch.from_numpy(model.initial([np.random.default_rng(k) for k in range(2)]))
    optimiser = Adam(epochs=10**6, schedule="cosine", batch_size=20, budget_s=0.1, engine=engine)
    optimiser.fit(problem, start, silent, NoCheckpoint())  # compiles
    before = time.process_time()
    fitted = optimiser.fit(problem, start, silent, NoCheckpoint())
    spent = time.process_time() - before
    assert 0.2 <= spent < 0.6
    assert 1 < fitted.notes["epochs"] < 10**6
    assert fitted.curves[-1][0] == fitted.notes["epochs"]
    half = optimiser._rates(1000, 1, spent=0.5)[0]
    assert half == pytest.approx(optimiser.learning_rate / 2 * np.sqrt(1 - 0.999**1001) / (1 - 0.9**1001), rel=1e-3)


def test_a_scale_shortens_the_budget_in_the_place_of_iterations():
    assert Adam(budget_s=600.0).shortened(0.1) == Adam(budget_s=60.0)
    assert LevenbergMarquardt(budget_s=600.0).shortened(0.1) == LevenbergMarquardt(budget_s=60.0)
    assert Adam(epochs=25).shortened(0.1).epochs == 3
