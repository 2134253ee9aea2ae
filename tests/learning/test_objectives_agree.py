"""One loss, written for torch, as CasADi expressions and as C: all give the same rows for every objective and model."""

import itertools
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np
import pytest
import torch

from repro.codegen.array_evaluation import evaluate
from repro.learning.native import native
from repro.learning.objective import Objective
from repro.learning.objectives import forward, inverse, mixed, port
from repro.learning.symbolic import symbols
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.models.bases import t1, t2
from repro.models.damped import Damped
from repro.models.kinds import blackbox, neural_potential, port_hamiltonian, structured
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.neural_potential import NeuralPotential
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian

pytestmark = pytest.mark.usefixtures("unoptimised")

SCALE = np.array([0.9, 5.0])
MODELS = {
    "coefficients": Lagrangian(t1, 2, momentum_hidden=(2,)),
    "network": Lagrangian(t2, 2, hidden=(4,)),
    "structured": Structured(2, SCALE, structured.Options(hidden=(3,))),
    "shared and floor": Structured(
        2, SCALE, structured.Options(hidden=(3,), factor="triangular", potential="shared", floor=0.1)
    ),
    "beside friction": Damped(Structured(2, SCALE, structured.Options(hidden=(3,))), "diagonal"),
    "neural potential": NeuralPotential(
        SCALE, np.ones(2), [1], neural_potential.Options(hidden=(3,), potential_hidden=(3,))
    ),
    "port-Hamiltonian": PortHamiltonian(
        Structured(2, SCALE, structured.Options(hidden=(3,))),
        SCALE,
        port_hamiltonian.Options(damping_hidden=(2,), momentum_hidden=(2,), floor=0.0),
    ),
    "black box": BlackBox(2, blackbox.Options(hidden=(3,))),
}
OBJECTIVES = {
    "inverse": Objective(inverse.Options()),
    "forward": Objective(forward.Options()),
    "mixed": Objective(mixed.Options(forward_weight=0.1, power_weight=2.0)),
    "port": Objective(port.Options()),
    "momentum": Objective(inverse.Options(momentum_weight=0.3)),
    "energy": Objective(inverse.Options(), energy_weight=0.4),
    "forward and energy": Objective(forward.Options(), energy_weight=0.4),
    "sum of energies alone": Objective(None, energy_weight=0.4, energy_form="sum"),
}
ONLY = {"port": ("port-Hamiltonian",), "momentum": ("coefficients", "port-Hamiltonian")}
PAIRS = [
    (model, objective)
    for model, objective in itertools.product(MODELS, OBJECTIVES)
    if model in ONLY.get(objective, MODELS) and (model != "black box" or objective == "forward")
]


@pytest.fixture
def weights():
    return lambda model: model.initial([np.random.default_rng(5)]) + 0.1


@pytest.mark.parametrize(("name", "objective"), PAIRS)
def test_all_ways_to_write_a_loss_agree(name, objective, free, weights):
    model, chosen = MODELS[name], OBJECTIVES[objective]
    problem = TrainingProblem(model, [make_task(model, free, chosen)], [0]).member(0)
    (task,), parameters = problem.tasks, weights(model)
    terms = model.evaluate(torch.from_numpy(parameters), task.prepared, chosen.mass)
    by_torch = chosen.rows(terms, task.measured)[0].numpy()

    s = symbols(model)
    rows = ca.Function("rows", s.inputs, [ca.densify(chosen.expression(model, s))])
    samples = [task.measured[key][0].numpy() for key in ("q", "qd", "qdd", "tau")]
    energy = task.measured["energy"][0].numpy()[:, None]
    by_casadi = evaluate(rows, *samples, energy, np.ones(1), parameters[0])
    np.testing.assert_allclose(by_casadi, by_torch, rtol=1e-7, atol=1e-9)

    compiled = native(problem)
    if compiled is not None:
        loss, _ = compiled.loss_and_gradient(0, parameters[0].copy())
        assert loss == pytest.approx((by_torch**2).sum() / task.samples, rel=1e-9)


@dataclass(frozen=True)
class Halved(forward.Options):
    """Half the error of qdd, in torch alone."""

    symbolic: ClassVar[bool] = False

    def rows(self, terms, measured):
        return super().rows(terms, measured) / 2


@pytest.mark.parametrize("name", ["network", "structured", "black box"])
def test_rows_without_an_expression_are_computed_by_torch_alone(name, free, weights):
    model = MODELS[name]
    problem = TrainingProblem(model, [make_task(model, free, Objective(Halved()))], [0]).member(0)
    whole = TrainingProblem(model, [make_task(model, free, OBJECTIVES["forward"])], [0]).member(0)
    parameters = torch.from_numpy(weights(model))
    assert native(problem) is None
    assert torch.allclose(4 * problem.loss(parameters), whole.loss(parameters), rtol=1e-12)


def test_rows_that_a_model_does_not_have_are_refused():
    model = MODELS["black box"]
    with pytest.raises(ValueError, match="accelerations only"):
        OBJECTIVES["inverse"].expression(model, symbols(model))
