"""Theorem 1: a port-Hamiltonian model is passive for any weights and at every step; other models are not."""

import numpy as np
import pytest
import torch

from repro.codegen.array_evaluation import evaluate
from repro.learning.objective import Objective
from repro.learning.objectives import port
from repro.learning.optimisers.adam import Adam
from repro.learning.optimisers.lbfgs import LBFGS
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.learning.watch import PassivityWatch
from repro.mechanics.derive import dynamics_of
from repro.models.bases import t1
from repro.models.damped import Damped
from repro.models.kinds import blackbox, port_hamiltonian, structured
from repro.models.kinds.blackbox import BlackBox
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian
from repro.models.passivity_margin import States, margins, worst_margin

SCALE = np.array([0.9, 5.0])
VARIANTS = [
    ("canonical", "none"),
    ("canonical", "constant"),
    ("canonical", "state"),
    ("free", "constant"),
    ("free", "state"),
    ("full", "state"),
]


def _model(structure, dissipation):
    energy = Structured(2, SCALE, structured.Options(hidden=(3,)))
    return PortHamiltonian(
        energy,
        SCALE,
        port_hamiltonian.Options(structure=structure, dissipation=dissipation, damping_hidden=(3,), floor=1e-3),
    )


@pytest.fixture
def states(system):
    return States.random(system.coordinates, SCALE, 500, np.random.default_rng(3))


@pytest.mark.parametrize(("structure", "dissipation"), VARIANTS)
def test_a_port_hamiltonian_model_is_passive_for_any_weights(structure, dissipation, states):
    model = _model(structure, dissipation)
    for size in (0.1, 1.0, 10.0):
        weights = np.random.default_rng(0).normal(scale=size, size=(3, model.n_parameters))
        assert worst_margin(model, weights, states).max() < 1e-12


@pytest.mark.parametrize(("structure", "dissipation"), VARIANTS)
def test_j_is_skew_and_r_is_positive_semidefinite(structure, dissipation, states):
    import casadi

    model = _model(structure, dissipation)
    q, qd = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2)
    theta = casadi.SX.sym("theta", model.n_parameters)
    both = [model.interconnection(q, qd, theta), model.resistance(q, qd, theta)]
    functions = [casadi.Function("matrix", [q, qd, theta], [casadi.densify(matrix)]) for matrix in both]
    weights = np.random.default_rng(0).normal(size=model.n_parameters)
    j, r = (evaluate(function, states.q, states.qd, weights) for function in functions)
    np.testing.assert_array_equal(j, -j.swapaxes(1, 2))
    np.testing.assert_allclose(r, r.swapaxes(1, 2), atol=1e-12)
    assert np.linalg.eigvalsh(r).min() >= -1e-12 * np.abs(r).max()


def test_the_energy_of_a_structured_model_is_bounded_below(states):
    """H >= -sum |beta|, as Theorem 1 needs; that of a linear basis is not."""
    model = _model("canonical", "state")
    weights = np.random.default_rng(1).normal(scale=3.0, size=model.n_parameters)
    energies = _energy(model, weights, states)
    assert energies.min() >= -abs(weights[model.energy.potential_slice]).sum()
    indefinite = PortHamiltonian(Lagrangian(t1, 2), SCALE, port_hamiltonian.Options(damping_hidden=(8,), floor=0.0))
    chosen = np.zeros(indefinite.n_parameters)
    chosen[0] = -1.0
    assert _energy(indefinite, chosen, states).min() < -1


def _energy(model, weights, states):
    import casadi

    q, qd = casadi.SX.sym("q", 2), casadi.SX.sym("qd", 2)
    theta = casadi.SX.sym("theta", model.n_parameters)
    energies = model.energies(q, qd, theta)
    function = casadi.Function("energy", [q, qd, theta], [casadi.densify(energies.kinetic + energies.potential)])
    return evaluate(function, states.q, states.qd, weights)


def test_a_lagrangian_beside_negative_friction_is_not_passive(states):
    model = Damped(Lagrangian(t1, 2), "diagonal")
    weights = np.zeros((2, model.n_parameters))
    weights[:, :4] = [0.4, 0.025, 0.1, 0.98]
    weights[:, 4:] = [[0.3, 0.01], [0.3, -0.01]]
    good, bad = worst_margin(model, weights, states)
    assert good <= 1e-12
    assert bad > 1e-4


def test_a_structure_free_model_makes_energy(states, system):
    model = BlackBox(2, blackbox.Options(hidden=(6,)))
    weights = model.initial([np.random.default_rng(0)])
    assert worst_margin(model, weights, states, storage=system)[0] > 1e-2


def test_the_plants_own_energy_judges_a_true_model_as_the_model_itself_does(states, system):
    model = Damped(Lagrangian(t1, 2), "diagonal")
    true = np.array([0.4, 0.025, 0.1, 0.98, 0.0, 0.0])
    assert np.abs(margins(model, true, states)).max() < 1e-14
    assert np.abs(margins(model, true, states, storage=system)).max() < 1e-13
    friction = np.array([0.4, 0.025, 0.1, 0.98, 0.3, 0.01])
    assert margins(model, friction, states, storage=system).max() <= 1e-13
    power = evaluate(dynamics_of(system).dissipated_power, states.q, states.qd)
    assert power.max() < 1e-12


@pytest.mark.parametrize(
    "optimiser",
    [LevenbergMarquardt(restarts=1, iterations=4), LBFGS(iterations=4), Adam(epochs=4)],
    ids=["lm", "lbfgs", "adam"],
)
def test_the_margin_is_watched_at_every_step(optimiser, data, states):
    model = _model("canonical", "state")
    seeds = [0, 1, 2]
    start = torch.from_numpy(model.initial([np.random.default_rng(seed) for seed in seeds]))
    problem = TrainingProblem(
        model, [make_task(model, data.train, Objective(port.Options()))], seeds, watches=[PassivityWatch(model, states)]
    )
    fitted = optimiser.fit(problem, start, silent, NoCheckpoint())
    margin = [values for _, name, values in fitted.curves if name == "passivity_margin"]
    assert len(margin) >= 4
    assert np.shape(margin[0]) == (3,)
    assert max(map(max, margin)) < 1e-12
    np.testing.assert_allclose(margin[-1], worst_margin(model, fitted.parameters.numpy(), states), rtol=1e-6)


def test_nothing_is_watched_unless_asked_for(data):
    model = _model("canonical", "none")
    start = torch.from_numpy(model.initial([np.random.default_rng(seed) for seed in range(3)]))
    problem = TrainingProblem(model, [make_task(model, data.train, Objective(port.Options()))], [0, 1, 2])
    fitted = LevenbergMarquardt(restarts=1, iterations=2).fit(problem, start, silent, NoCheckpoint())
    assert {name for _, name, _ in fitted.curves} == {"loss"}
