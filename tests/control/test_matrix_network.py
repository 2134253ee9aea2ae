"""A wide network in matrix operations against the same network as scalar expressions."""

import casadi as ca
import numpy as np
import pytest

from repro.control import predictive_model as matrix_network
from repro.control.interval import interval
from repro.control.optimal_control_problem import NodeWeights, Obstacle, OptimalControlProblem
from repro.control.predictive_model import MatrixNetwork, PredictiveModel
from repro.mechanics.inputs import input_map
from repro.models.bases import t2
from repro.models.lagrangian import Lagrangian


@pytest.fixture
def model():
    return Lagrangian(t2, 2, hidden=(7, 5))


def test_its_functions_are_those_of_the_scalar_form(model, system):
    scalar, matrices = PredictiveModel(model, system, canonical=False), MatrixNetwork(model, input_map(system))
    generator = np.random.default_rng(0)
    (weights,) = model.initial([generator])
    for _ in range(5):
        x, qdd = generator.normal(size=4), generator.normal(size=2)
        for name, given in (("energy", (x,)), ("derivative", (x, 1.3)), ("inverse", (x, qdd, 1.3))):
            ours, expected = (
                np.asarray(ca.vertcat(*_all(getattr(m, name)(*given, weights)))) for m in (matrices, scalar)
            )
            np.testing.assert_allclose(ours, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
def test_an_interval_of_it_is_the_same(model, system, discretisation, monkeypatch):
    problem = OptimalControlProblem(
        (0.04,) * 3, NodeWeights(potential=1.0, position=1.0), NodeWeights(kinetic=1.0), Obstacle(midpoints=True)
    )
    values = []
    for largest in (10**6, 0):
        monkeypatch.setattr(matrix_network, "LARGEST_SCALAR", largest)
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


def _all(result):
    return result if isinstance(result, tuple) else (result,)
