"""A wide network in matrix operations against the same network as scalar expressions."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from repro.control import predictive_model
from repro.control.interval import interval
from repro.control.optimal_control_problem import NodeWeights, Obstacle, OptimalControlProblem
from repro.control.predictive_model import PredictiveModel
from repro.control.programme import programme
from repro.control.transcription import Transcription
from repro.models.bases import t2
from repro.models.lagrangian import Lagrangian


@pytest.fixture
def model():
    return Lagrangian(t2, 2, hidden=(7, 5))


def test_its_functions_are_those_of_the_scalar_form(model, system, monkeypatch):
    values = []
    for largest in (10**6, 0):
        monkeypatch.setattr(predictive_model, "LARGEST_SCALAR", largest)
        predictive, generator = PredictiveModel(model, system, canonical=False), np.random.default_rng(0)
        assert predictive.is_wide == (largest == 0)
        (weights,) = model.initial([generator])
        for _ in range(5):
            x, qdd = generator.normal(size=4), generator.normal(size=2)
            parts = *predictive.energy(x, weights), predictive.derivative(x, 1.3, weights)
            values.append(np.asarray(ca.vertcat(*parts, predictive.inverse(x, qdd, 1.3, weights))))
    np.testing.assert_allclose(values[:5], values[5:], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
def test_an_interval_of_it_is_the_same(model, system, discretisation, monkeypatch):
    problem = OptimalControlProblem(
        (0.04,) * 3, NodeWeights(potential=1.0, position=1.0), NodeWeights(kinetic=1.0), Obstacle(midpoints=True)
    )
    values = []
    for largest in (10**6, 0):
        monkeypatch.setattr(predictive_model, "LARGEST_SCALAR", largest)
        made = interval(PredictiveModel(model, system, canonical=False), problem, discretisation, 2)
        inputs = [made.state, made.inner, made.parameters, made.data]
        function = ca.Function("interval", inputs, [made.following, made.equalities, made.cost])
        generator = np.random.default_rng(1)
        (weights,) = model.initial([generator])
        inner = generator.normal(size=made.inner.shape[0])
        values.append(function(generator.normal(size=4), inner, np.append([0.8, 0.0, 0.0], weights), [0.04, 1.0]))
    for first, second in zip(*values, strict=True):
        np.testing.assert_allclose(np.asarray(first), np.asarray(second), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("hidden", [(41, 41), (42, 42)], ids=["scalars", "matrices"])
def test_both_sides_of_the_threshold_give_the_derivative_of_the_scalar_form(system, hidden):
    model = Lagrangian(t2, 2, hidden=hidden)
    predictive = PredictiveModel(model, system)
    generator = np.random.default_rng(2)
    (weights,) = model.initial([generator])
    x = generator.normal(size=4)
    q, qd, w = ca.SX.sym("q", 2), ca.SX.sym("qd", 2), ca.SX.sym("w", len(weights))
    qdd = ca.Function("qdd", [q, qd, w], [model.acceleration(q, qd, ca.vertcat(1.3, 0.0), w)])(x[:2], x[2:], weights)
    rate = np.asarray(predictive.derivative(x, 1.3, weights)).ravel()
    np.testing.assert_allclose(rate, np.concatenate([x[2:], np.asarray(qdd).ravel()]), rtol=1e-9)


def test_the_derivatives_of_a_programme_hold_the_weights_a_few_times(problem, system):
    """Differentiated by its weights too, as nothing needs, a Hessian would hold them 150 times."""
    model = Lagrangian(t2, 2, hidden=(45, 45))
    of = Transcription(PredictiveModel(model, system), replace(problem, intervals=(0.04, 0.04)), "collocation")
    made = programme(of)
    for name in ("g", "jac_g_x", "triu_hess_gamma_x_x"):
        assert made.function("one", [name]).sz_w() < 30 * model.n_parameters, name
