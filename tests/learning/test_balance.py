"""The momentum balance over windows: exact in the limit, the same by every engine, and closed where tau is linear."""

import numpy as np
import pytest
import torch
from simulated import random_force

from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.learning.members import MemberProblem
from repro.learning.objective import Objective
from repro.learning.objectives import balance
from repro.learning.objectives.balance import balance_task
from repro.learning.optimisers.least_squares import LeastSquares
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import t1
from repro.models.kinds import structured
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model

SYSTEM = load("sip")
TRUE = np.array([0.4, 0.025, 0.1, 0.98])  # (m0 + m1) / 2, m1 L1^2 / 2, m1 L1, m1 g L1


def _data(time_step: float = 0.02, labels: str = "differenced") -> Dataset:
    return random_force(
        SYSTEM, seeds=[3], samples=300, episode_steps=50, reset="random", time_step=time_step, measured="states",
        labels=labels,
    ).train  # fmt: skip


def _problem(model: Model, data: Dataset, window: float = 0.1) -> TrainingProblem:
    return TrainingProblem(model, [balance_task(model, data, Objective(balance.Options()), window, 20.0)], seeds=[0])


def test_the_rows_vanish_at_the_truth_with_the_fourth_power_of_the_step() -> None:
    model = Lagrangian(t1, 2)
    errors = []
    for step in (0.04, 0.02):
        rows, _ = _problem(model, _data(step), window=0.2).linearise(torch.tensor(TRUE)[None])
        errors.append(float(rows.abs().max()))
    assert errors[0] / errors[1] > 6
    assert errors[1] < 1e-4


def test_the_closed_form_finds_the_coefficients_from_states_alone() -> None:
    model = Lagrangian(t1, 2)
    found = LeastSquares(cutoff=1e-5).fit(_problem(model, _data()), torch.zeros(1, 4), silent, NoCheckpoint())
    np.testing.assert_allclose(found.parameters[0], TRUE, rtol=1e-4)


@pytest.mark.parametrize(
    "model", [Lagrangian(t1, 2), Structured(2, np.array([1.0, 3.0]), structured.Options(hidden=(3,)))]
)
def test_all_engines_agree(model: Model) -> None:
    problem = _problem(model, _data())
    weights = model.initial([np.random.default_rng(1)])[0]
    member = MemberProblem(problem)
    loss = problem.loss(torch.from_numpy(weights)[None])[0].item()
    rows, jacobian = member.linearise(weights)
    gram, gradient = member.normal_equations(weights)
    assert member.loss(weights) == pytest.approx(loss)
    assert rows @ rows == pytest.approx(loss)
    np.testing.assert_allclose(gram, jacobian.T @ jacobian, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(member.loss_and_gradient(weights)[1], 2 * gradient, rtol=1e-9, atol=1e-12)
    step = 1e-6 * np.random.default_rng(2).standard_normal(len(weights))
    slope = (member.loss(weights + step) - member.loss(weights - step)) / 2
    assert slope == pytest.approx(2 * gradient @ step, rel=1e-5)


def test_a_batch_holds_whole_windows() -> None:
    problem = _problem(Lagrangian(t1, 2), _data())
    weights = torch.tensor(TRUE + 0.01)[None]
    index = torch.arange(problem.samples)[None]
    parts = [problem.loss(weights, part).item() * part.shape[1] for part in index.chunk(2, dim=1)]
    assert sum(parts) / problem.samples == pytest.approx(problem.loss(weights).item())


def test_a_window_longer_than_every_episode_is_refused() -> None:
    with pytest.raises(UserError, match=r"objective\.window"):
        _problem(Lagrangian(t1, 2), _data(), window=5.0)
