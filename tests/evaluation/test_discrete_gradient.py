"""The discrete gradient keeps or loses energy exactly as the system does, and is of second order."""

import numpy as np
import pytest
from optional import needs_compiler

from repro.codegen.array_evaluation import evaluate
from repro.evaluation import discrete_gradient
from repro.evaluation.discrete_gradient import integrate, phase_space
from repro.mechanics.simulate import simulate
from repro.models.bases import t1
from repro.models.kinds import port_hamiltonian
from repro.models.kinds.port_hamiltonian import PortHamiltonian
from repro.models.lagrangian import Lagrangian
from repro.models.model import acceleration

TRUE_T1 = np.array([0.4, 0.025, 0.1, 0.98])
START = np.array([[0.0, 1.0, 0.3, 2.0], [0.1, -2.5, -0.5, 1.0]])


def _model(dissipation="none", structure="canonical"):
    model = PortHamiltonian(
        Lagrangian(t1, 2),
        np.array([1.0, 3.0]),
        port_hamiltonian.Options(structure=structure, dissipation=dissipation, damping_hidden=(3,), floor=0.0),
    )
    weights = model.initial([np.random.default_rng(0)])[0]
    weights[model.energy_slice] = TRUE_T1
    return model, np.stack([weights, weights])


def _phase(space, parameters):
    return evaluate(space.to_phase, START, parameters)


def test_the_energy_is_kept_without_damping():
    model, parameters = _model()
    space = phase_space(model)
    states = integrate(space, _phase(space, parameters), 400, 0.05, parameters)
    energy = evaluate(space.energy, states, parameters[:, None])[..., 0]
    assert np.abs(energy - energy[:, :1]).max() < 1e-10


@pytest.mark.parametrize("structure", ["canonical", "free", "full"])
def test_the_energy_never_rises_with_any_weights(structure):
    """Also with coarse steps: the inequality holds for the discrete system itself."""
    model, parameters = _model("state", structure)
    space = phase_space(model)
    states = integrate(space, _phase(space, parameters), 200, 0.02, parameters)
    energy = evaluate(space.energy, states, parameters[:, None])[..., 0]
    assert np.isfinite(energy).all()
    assert np.diff(energy, axis=1).max() < 1e-10


def test_it_is_of_second_order():
    model, parameters = _model("constant")
    space = phase_space(model)
    start = _phase(space, parameters)
    fine = simulate(acceleration(model), START, np.zeros((2, 100, 2)), 0.01, substeps=20, parameters=parameters)[:, -1]
    errors = []
    for steps in (50, 100, 200):
        last = integrate(space, start, steps, 1.0 / steps, parameters)[:, -1]
        errors.append(np.abs(evaluate(space.to_rates, last, parameters) - fine).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)


def test_phase_and_rates_are_inverse_to_each_other():
    model, parameters = _model("constant")
    space = phase_space(model)
    np.testing.assert_allclose(evaluate(space.to_rates, _phase(space, parameters), parameters), START, atol=1e-13)


def test_other_models_have_the_canonical_structure():
    model = Lagrangian(t1, 2)
    parameters = np.stack([TRUE_T1, TRUE_T1])
    space = phase_space(model)
    own, own_parameters = _model()
    theirs = integrate(phase_space(own), _phase(phase_space(own), own_parameters), 20, 0.02, own_parameters)
    np.testing.assert_allclose(integrate(space, _phase(space, parameters), 20, 0.02, parameters), theirs, atol=1e-12)


def test_a_step_that_cannot_be_solved_is_not_a_number():
    model, parameters = _model()
    space = phase_space(model)
    states = integrate(space, _phase(space, parameters), 3, 50.0, parameters)
    assert np.isnan(states[:, 1:]).all()


def test_a_kinetic_energy_that_is_not_quadratic_is_refused():
    from repro.models.bases import t2

    with pytest.raises(ValueError, match="not quadratic"):
        phase_space(Lagrangian(t2, 2, hidden=(3,)))


@pytest.mark.parametrize("structure", ["canonical", "free", "full"])
def test_it_goes_on_while_a_damped_motion_comes_to_rest(structure):
    """Moves become so small that rounding rules the correction of the mean slope."""
    model, parameters = _model("constant", structure)
    space = phase_space(model)
    hanging = np.array([[0.0, np.pi, 1e-3, 1e-3], [0.0, np.pi + 1e-4, 0.0, 1e-4]])
    states = integrate(space, evaluate(space.to_phase, hanging, parameters), 2000, 0.05, parameters)
    energy = evaluate(space.energy, states, parameters[:, None])[..., 0]
    assert np.isfinite(states).all()
    assert np.diff(energy, axis=1).max() < 1e-12


@needs_compiler
@pytest.mark.parametrize("dissipation", ["none", "state"])
def test_the_compiled_iteration_follows_the_interpreted_one(dissipation, monkeypatch):
    model, parameters = _model(dissipation)
    parameters[1] *= 1.1
    space = phase_space(model)
    start = _phase(space, parameters)
    interpreted = integrate(space, start, 300, 0.02, parameters)
    monkeypatch.setattr(discrete_gradient, "COMPILED_FROM", 1)
    np.testing.assert_allclose(integrate(space, start, 300, 0.02, parameters), interpreted, atol=1e-10)


@needs_compiler
def test_a_compiled_step_that_cannot_be_solved_spoils_its_own_trajectory_only(monkeypatch):
    model, parameters = _model()
    space = phase_space(model)
    start = _phase(space, parameters)
    start[0, 3] = np.nan
    monkeypatch.setattr(discrete_gradient, "COMPILED_FROM", 1)
    states = integrate(space, start, 20, 0.02, parameters)
    assert np.isnan(states[0, 1:]).all()
    assert np.isfinite(states[1]).all()
