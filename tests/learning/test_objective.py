"""The rows of a loss against the equations that they stand for."""

import casadi
import numpy as np
import torch
from tensors import assert_close

from repro.codegen.array_evaluation import evaluate
from repro.learning.objective import Objective
from repro.learning.objectives import forward, inverse
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.derive import derive
from repro.models.bases import t2
from repro.models.lagrangian import Lagrangian

MODEL = Lagrangian(t2, 2, hidden=(4,))


def _evaluated(task, parameters):
    return MODEL.evaluate(parameters, task.prepared, mass=True)


def test_forward_rows_are_casadis_acceleration_minus_the_measured_one(data, start):
    parameters, part = start(MODEL), data.train
    task = make_task(MODEL, part, Objective(forward.Options()))
    rows = task.objective.rows(_evaluated(task, parameters), task.measured).numpy()
    q, qd, weights = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2), casadi.SX.sym("w", MODEL.n_parameters)
    energies = MODEL.energies(q, qd, weights)
    learned = derive(energies.kinetic, energies.potential, casadi.SX(0), q, qd, weights)
    own = np.repeat(parameters.numpy()[:, None], part.samples, axis=1)
    expected = evaluate(learned.acceleration, part.q, part.qd, part.tau, own) - part.qdd
    np.testing.assert_allclose(rows, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())


def test_the_forward_gradient_is_the_inverse_one_with_the_adjoint(data, start):
    """d/dw |e|^2 = d/dw lambda . tau_hat(q, qd, qdd_hat; w), lambda = -2 M^-1 e, at the predicted acceleration."""
    parameters, part = start(MODEL), data.train
    task = make_task(MODEL, part, Objective(forward.Options()))
    problem = TrainingProblem(MODEL, [task], [0, 1, 2])
    weights = parameters.clone().requires_grad_()
    (expected,) = torch.autograd.grad(problem.loss(weights).sum(), weights)
    terms = _evaluated(task, parameters)
    error = terms.acceleration_error(task.measured["qdd"], task.measured["tau"])
    adjoint = -2 * torch.linalg.solve(terms.mass, error)
    predicted = MODEL.prepare(part.q, part.qd, part.qdd + error.numpy(), part.tau)
    weights = parameters.clone().requires_grad_()
    tau = MODEL.evaluate(weights, {name: torch.from_numpy(a) for name, a in predicted.items()}).tau
    (gradient,) = torch.autograd.grad((adjoint * tau).sum() / part.samples, weights)
    assert_close(gradient, expected, rtol=1e-8, atol=1e-9 * expected.abs().max().item())


def test_energy_rows_ask_for_the_legendre_transform_or_the_printed_sum(free, start):
    parameters, energy = start(MODEL), torch.from_numpy(free.train.energy)
    for form, ours in (
        ("legendre", lambda terms, qd: (terms.momentum * qd).sum(-1) - terms.kinetic + terms.potential),
        ("sum", lambda terms, qd: terms.kinetic + terms.potential),
    ):
        task = make_task(MODEL, free.train, Objective(None, energy_weight=4.0, energy_form=form))
        terms = _evaluated(task, parameters)
        rows = task.objective.rows(terms, task.measured)
        expected = 2 * (ours(terms, task.measured["qd"]) - energy)
        assert_close(rows, expected.unsqueeze(-1))


def test_rows_come_in_order_with_the_roots_of_their_weights(free, start):
    model = Lagrangian(t2, 2, hidden=(4,), momentum_hidden=(2,))
    task = make_task(model, free.train, Objective(inverse.Options(momentum_weight=9.0), energy_weight=0.25))
    terms = model.evaluate(start(model), task.prepared)
    rows = task.objective.rows(terms, task.measured)
    assert rows.shape[-1] == 2 + 2 + 1
    assert_close(rows[..., :2], terms.tau - task.measured["tau"])
    assert_close(rows[..., 2:4], 3 * (terms.transformed_momentum - terms.momentum))
    expected = 0.5 * (terms.hamiltonian(task.measured["qd"]) - task.measured["energy"])
    assert_close(rows[..., 4], expected)


def test_only_the_forward_equation_needs_the_mass_matrix():
    assert Objective(forward.Options()).mass
    assert not Objective(inverse.Options(), energy_weight=1.0).mass
    assert not Objective(None, energy_weight=1.0).mass
