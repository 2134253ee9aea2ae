"""The damping metrics, and that friction is identified in closed form."""

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.evaluation.dissipation import damping_errors
from repro.learning.objective import Objective
from repro.learning.optimisers.least_squares import LeastSquares
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import rigid_body, t1
from repro.models.context import Context
from repro.models.damped import Damped
from repro.models.kinds import structured
from repro.models.kinds.lagrangian import Options, build
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian

DAMPING = (0.3, 0.01)


@pytest.fixture(scope="module")
def damped():
    return load("sip", damping=DAMPING)


@pytest.fixture(scope="module")
def data(damped):
    return random_force(damped, seeds=[0, 1], samples=400, reset="random", episode_steps=50)


def _errors(model, parameters, data, system):
    return {metric.name: metric.values for metric in damping_errors(model, parameters, data.test, system)}


@pytest.mark.parametrize("shape", ["diagonal", "full"])
def test_friction_is_identified_in_closed_form(shape, data, damped):
    model = Damped(Lagrangian(t1, 2), shape)
    problem = TrainingProblem(model, [make_task(model, data.train, Objective())], [0, 1])
    start = torch.zeros(2, model.n_parameters, dtype=torch.float64)
    fitted = LeastSquares().fit(problem, start, silent, NoCheckpoint())
    errors = _errors(model, fitted.parameters, data, damped)
    assert max(errors["damping_error"]) < 1e-9
    np.testing.assert_allclose(errors["min_eig_C"], min(DAMPING), rtol=1e-9)


def test_friction_of_a_free_rod_is_identified():
    """The angle of a free rod follows a translation, on which it does not turn."""
    system = load("rod", damping=(0.1, 0.2, 0.01))
    data = random_force(system, seeds=[0], samples=400, reset="random", episode_steps=50)
    context = Context(rigid_body, system.coordinates, data.train.q, data.train.qd, data.train.qd, system)
    model = build(context, Options(damping="diagonal"))
    problem = TrainingProblem(model, [make_task(model, data.train, Objective())], [0])
    start = torch.zeros(1, model.n_parameters, dtype=torch.float64)
    fitted = LeastSquares().fit(problem, start, silent, NoCheckpoint())
    np.testing.assert_allclose(fitted.parameters[0, -3:], system.damping, rtol=1e-9)
    errors = _errors(model, fitted.parameters, data, system)
    assert all(errors[name][0] < 1e-9 for name in ("damping_error", *(f"damping_error[{i}]" for i in range(3))))


def test_each_joint_has_its_own_error(data, damped):
    model = Damped(Lagrangian(t1, 2), "full")
    parameters = torch.zeros(2, model.n_parameters, dtype=torch.float64)
    parameters[:, -3:] = torch.tensor([[0.3, 0.0, 0.015], [0.15, 0.0, 0.01]], dtype=torch.float64)
    errors = _errors(model, parameters, data, damped)
    np.testing.assert_allclose(errors["damping_error[0]"], [0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(errors["damping_error[1]"], [0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(errors["damping_error"], [0.005, 0.15] / np.hypot(*DAMPING))


def test_a_joint_of_a_chain_is_judged_on_its_relative_rate():
    """C of c0, c1, c2 on relative rates, as absolute entries: [[c0, 0, 0], [0, c1 + c2, -c2], [0, -c2, c2]]."""
    system = load("dip", damping=(0.3, 0.01, 0.005))
    data = random_force(system, seeds=[0], samples=20, episode_steps=10)
    model = Damped(Structured(3, np.ones(3), structured.Options()), "full")
    entries = torch.tensor([[0.3, 0.0, 0.0, 0.015, -0.005, 0.005]], dtype=torch.float64)
    zeros = torch.zeros(1, model.n_parameters - 6, dtype=torch.float64)
    assert max(_errors(model, torch.cat([zeros, entries], dim=1), data, system)["damping_error"]) < 1e-12
    double = entries + torch.tensor([[0, 0, 0, 0.005, -0.005, 0.005]])
    errors = _errors(model, torch.cat([zeros, double], dim=1), data, system)
    values = [errors[f"damping_error[{joint}]"][0] for joint in range(3)]
    np.testing.assert_allclose(values, [0.0, 0.0, 1.0], atol=1e-12)


def test_nothing_is_said_without_friction(data, damped):
    model = Lagrangian(t1, 2)
    assert not _errors(model, torch.zeros(2, model.n_parameters), data, damped)
    beside = Damped(model, "full")
    assert not _errors(beside, torch.zeros(2, beside.n_parameters), data, load("sip"))
