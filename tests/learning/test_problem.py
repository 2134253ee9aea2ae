"""A problem's loss is the mean over samples of the squared rows; parts of it are the same problem."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from tensors import assert_close

from repro.learning.objective import Objective
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import t1, t2
from repro.models.lagrangian import Lagrangian

MODEL = Lagrangian(t2, 2, hidden=(4,))


@pytest.fixture
def problem(data, free):
    tasks = [
        make_task(MODEL, data.train, Objective(), error_scale=15.0),
        make_task(MODEL, free.train, Objective(None, energy_weight=0.5)),
    ]
    return TrainingProblem(MODEL, tasks, [0, 1, 2], torch.linspace(0, 1, MODEL.n_parameters, dtype=torch.float64))


def test_the_loss_is_the_weighted_mean_of_squares(data, start, make_problem):
    """(7a) summed over components, each sample weighed by 1 / (1 + |qdd|^2 / s^2)."""
    model, part = Lagrangian(t1, 2), data.train
    problem = make_problem(model, data, error_scale=15.0)
    parameters = start(model)
    tau = model.evaluate(parameters, problem.tasks[0].prepared).tau.numpy()
    weight = 1 / (1 + (part.qdd**2).sum(-1) / 15.0**2)
    expected = (weight * ((tau - part.tau) ** 2).sum(-1)).mean(1)
    np.testing.assert_allclose(problem.loss(parameters).numpy(), expected, rtol=1e-12)


def test_linearised_rows_square_to_the_loss_and_their_jacobian_to_its_gradient(problem, start):
    without = TrainingProblem(problem.model, problem.tasks, problem.seeds)
    parameters = start(MODEL).requires_grad_()
    loss = without.loss(parameters)
    (gradient,) = torch.autograd.grad(loss.sum(), parameters)
    rows, jacobian = without.linearise(parameters.detach())
    assert_close(rows.square().sum(1), loss.detach())
    assert_close(2 * torch.einsum("mr,mrp->mp", rows, jacobian), gradient)


def test_the_l1_terms_are_added_once(problem, start):
    parameters = start(MODEL)
    without = TrainingProblem(problem.model, problem.tasks, problem.seeds)
    expected = without.loss(parameters) + parameters.abs() @ problem.l1
    assert_close(problem.loss(parameters), expected)


def test_batches_of_equal_size_average_to_the_whole(problem, start):
    """Each batch takes some of the first task and all of the others."""
    parameters = start(MODEL)
    order = torch.arange(135).repeat(3, 1)
    batches = [problem.loss(parameters, order[:, first : first + 27]) for first in range(0, 135, 27)]
    assert_close(torch.stack(batches).mean(0), problem.loss(parameters))


def test_a_member_alone_has_its_own_loss(problem, start):
    parameters = start(MODEL)
    alone = torch.cat([problem.member(m).loss(parameters[m : m + 1]) for m in range(3)])
    assert_close(alone, problem.loss(parameters), rtol=1e-12, atol=0)
    assert problem.member(2).seeds == [2]


def test_a_sub_sample_is_drawn_by_each_members_seed(problem):
    reduced = problem.subsample(40)
    assert reduced.samples == 40
    assert reduced.tasks[1] is problem.tasks[1]
    again = problem.subsample(40)
    q, more = reduced.tasks[0].measured["q"], problem.tasks[0].measured["q"]
    assert torch.equal(q, again.tasks[0].measured["q"])
    for member in range(3):
        known = {tuple(row) for row in more[member].tolist()}
        chosen = [tuple(row) for row in q[member].tolist()]
        at_rest = chosen.count((0.0, 0.0))  # every episode starts there, the other states occur once
        assert known.issuperset(chosen)
        assert len(set(chosen)) == 40 - max(0, at_rest - 1)
    assert problem.subsample(None) is problem
    assert problem.subsample(500) is problem


def test_members_draw_differently_from_the_same_data(data, make_problem):
    names = ("q", "qd", "qdd", "tau")
    same = replace(data, **{name: np.repeat(getattr(data, name)[:1], 3, axis=0) for name in names})
    tau = make_problem(Lagrangian(t1, 2), same).subsample(40).tasks[0].measured["tau"]
    assert not torch.equal(tau[0], tau[1])


def test_a_members_sub_sample_does_not_depend_on_its_company(problem):
    alone = problem.member(1).subsample(40).tasks[0].measured["tau"]
    assert torch.equal(alone, problem.subsample(40).tasks[0].measured["tau"][1:2])
