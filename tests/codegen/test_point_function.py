"""Functions at many points: compiled code against CasADi's own evaluation."""

import casadi as ca
import numpy as np
import pytest
from optional import needs_compiler

from repro.codegen import array_evaluation
from repro.codegen.array_evaluation import evaluate
from repro.codegen.point_function import LEAST_POINTS, MOST_INSTRUCTIONS, pays

X, NOTHING, WEIGHTS = ca.SX.sym("x", 3), ca.SX.sym("nothing", 0), ca.SX.sym("weights", 2)
MATRIX = ca.horzcat(ca.sin(X) * WEIGHTS[0], ca.exp(X[::-1]) - WEIGHTS[1] ** 2)
FUNCTION = ca.Function("matrix", [X, NOTHING, WEIGHTS], [MATRIX])


@needs_compiler
@pytest.mark.parametrize("one_set_of_weights", [True, False])
@pytest.mark.parametrize("points", [1, 8, 21])
def test_compiled_values_are_those_of_casadi(points, one_set_of_weights, monkeypatch):
    generator = np.random.default_rng(points)
    x, weights = generator.normal(size=(2, points, 3)), generator.normal(size=(2, 1, 2))
    arrays = x, np.zeros(0), weights[0, 0] if one_set_of_weights else weights
    expected = evaluate(FUNCTION, *arrays)
    monkeypatch.setattr(array_evaluation, "pays", lambda function, points: True)
    monkeypatch.setattr(array_evaluation, "_map", None)
    np.testing.assert_allclose(evaluate(FUNCTION, *arrays), expected, rtol=1e-14, atol=1e-15)


def test_only_much_work_of_a_short_dense_function_is_compiled():
    def function(count):
        x = ca.SX.sym("x")
        values = [x]
        for _ in range(count):
            values.append(ca.sin(values[-1]))
        return ca.Function("f", [x], [ca.vertcat(*values)])

    long, short = function(MOST_INSTRUCTIONS), function(1)
    usual, sparse = function(500), ca.Function("f", [X], [ca.diag(X)])
    assert pays(usual, LEAST_POINTS) and not pays(usual, LEAST_POINTS - 1)
    assert not any(pays(each, LEAST_POINTS) for each in (long, short, sparse))
