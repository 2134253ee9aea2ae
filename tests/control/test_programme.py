"""The programme put together from stages against CasADi's own derivatives of the whole, and its layout."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from repro.control.optimal_control_problem import NodeWeights, Obstacle
from repro.control.predictive_model import PredictiveModel
from repro.control.programme import programme
from repro.control.transcription import Transcription
from repro.mechanics.system import load
from repro.models.kinds import neural_potential
from repro.models.kinds.neural_potential import NeuralPotential

VARIANTS = {
    "soft": {},
    "hard": {"obstacle": Obstacle(constraint=True, midpoints=True)},
    "free": {"obstacle": None},
    "set point": {
        "stage_cost": NodeWeights(angle=2.0, position=1.0, rates=0.1),
        "terminal_cost": NodeWeights(angle=5.0),
    },
}


@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_derivatives_are_those_of_the_whole(problem, transcribe, variant, discretisation):
    of = transcribe(replace(problem, intervals=(0.04, 0.04, 0.08), **VARIANTS[variant]), discretisation)
    assert_consistent(of)


@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
def test_two_inputs_whose_directions_turn(problem, discretisation):
    system = load("quadrotor")
    model = PredictiveModel(
        NeuralPotential(np.ones(3), np.ones(3), (2,), neural_potential.Options(hidden=(2,))), system
    )
    changed = replace(problem, intervals=(0.04, 0.08), obstacle=None, potential_goal="goal", force_limit=(6.0, 5.0))
    of = Transcription(model, changed, discretisation)
    assert_consistent(of)
    limits = of.inner(of.bounds()["ubx"])[:, : of.n_u]
    np.testing.assert_array_equal(limits, [[6.0, 5.0]] * 2)


def assert_consistent(of):
    made = programme(of)
    x, _, lam_f, lam_g = inputs = [made.inputs[name] for name in ("x", "p", "lam_f", "lam_g")]
    f, g = made.outputs["f"], made.outputs["g"]
    lagrangian = lam_f * f + ca.dot(lam_g, g)
    pairs = [
        (made.outputs["grad_f_x"], ca.gradient(f, x)),
        (made.outputs["jac_g_x"], ca.jacobian(g, x)),
        (made.outputs["hess_gamma_x_x"], ca.hessian(lagrangian, x)[0]),
        (made.outputs["grad_gamma_x"], ca.gradient(lagrangian, x)),
    ]
    both = ca.Function("both", inputs, [part for pair in pairs for part in pair])
    generator = np.random.default_rng(0)
    values = [np.asarray(value) for value in both(*(generator.normal(size=like.shape[0]) for like in inputs))]
    for ours, expected in zip(values[::2], values[1::2], strict=True):
        np.testing.assert_allclose(ours, expected, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
def test_packing_and_unpacking(problem, transcribe, discretisation, state):
    of = transcribe(problem, discretisation)
    generator = np.random.default_rng(0)
    states, inner = generator.normal(size=(of.n_intervals + 1, of.n_x)), generator.normal(size=(of.n_intervals, of.n_v))
    variables = of.variables(states, inner)
    assert variables.shape == (of.n_variables,)
    np.testing.assert_array_equal(of.states(variables), states)
    np.testing.assert_array_equal(of.inner(variables), inner)
    np.testing.assert_array_equal(of.inner(of.guess(states, inner[:, :1]))[:, 0], inner[:, 0])


def test_a_straight_motion_guessed_satisfies_the_polynomials(problem, transcribe):
    """Of the collocation's equations, those without the model hold along a motion of constant speed."""
    of = transcribe(replace(problem, obstacle=None), "collocation")
    nodes = np.concatenate([[0.0], np.cumsum(problem.intervals)])
    rates = np.array([0.7, -1.1])
    states = np.concatenate([np.outer(nodes, rates), np.tile(rates, (len(nodes), 1))], axis=1)
    made = programme(of)
    g = made.function("g", ["g"])
    parameters = of.parameters(states[0], np.zeros(2), np.zeros(of.model.model.n_parameters))
    found = np.asarray(g(of.guess(states, np.zeros((of.n_intervals, 1))), parameters)).ravel()
    np.testing.assert_allclose(found, 0.0, atol=1e-12)


def test_bounds(problem, transcribe):
    of = transcribe(replace(problem, obstacle=Obstacle(constraint=True)), "shooting")
    bounds = of.bounds()
    assert np.all(of.inner(bounds["ubx"])[:, 0] == 4.0) and np.all(bounds["lbx"] == -bounds["ubx"])
    assert np.all(of.states(bounds["ubx"])[1:, 2:] == 45.0) and np.all(np.isinf(of.states(bounds["ubx"])[:, :2]))
    free = np.flatnonzero(np.isinf(bounds["lbg"]))
    assert list(free) == [4], "where we are already, the hard obstacle cannot be kept away from"
    assert np.sum(np.isinf(bounds["ubg"])) == 21, "one margin a node"
    assert sum(of.rows) == len(bounds["ubg"])
