"""Generated vector code against CasADi, lane by lane."""

import ctypes

import casadi as ca
import numpy as np
from optional import needs_compiler

from repro.codegen.c_library import load_library
from repro.codegen.lanes import FUNCTIONS, LANES, TYPE, vector_function

pytestmark = needs_compiler


def evaluated(function, values):
    """The kernel of a function of one input on values (LANES, n)."""
    call = "void call(const double *x, double *y) { apply((const vec *)x, (vec *)y); }\n"
    library = load_library(TYPE + FUNCTIONS + vector_function(function, ("x",)) + call, ("-O1",))
    # vectors want to lie at multiples of their size
    room = np.zeros((2, 64 * LANES))
    given, result = (row[(-row.ctypes.data // 8) % 8 :] for row in room)
    given[: values.size] = values.T.ravel()
    library.call(ctypes.c_void_p(given.ctypes.data), ctypes.c_void_p(result.ctypes.data))
    return result[: function.numel_out(0) * LANES].reshape(-1, LANES).T


def test_every_operation_is_that_of_casadi():
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    one = [ca.sqrt(a), ca.exp(b), ca.expm1(b), ca.log(a), ca.log1p(a), ca.sin(b), ca.cos(b), ca.tan(b), ca.tanh(b)]
    one += [ca.sinh(b), ca.cosh(b), ca.atan(b), ca.fabs(b), ca.sign(b), -b, 1 / a, b**2, 2 * b, ca.SX(0.25)]
    two = [a + b, a - b, a * b, a / b, a**b, a**2.5, ca.fmax(a, b), ca.fmin(a, b), ca.atan2(a, b), a < b, a <= b]
    two += [ca.eq(a, b), ca.ne(a, b), ca.logic_and(a < b, b < 1), ca.logic_or(a < b, b < 0), ca.logic_not(a < b)]
    two += [ca.if_else(a < b, a, 0)]
    function = ca.Function("apply", [ca.vertcat(a, b)], [ca.vertcat(*one, *two)])
    generator = np.random.default_rng(0)
    values = np.stack([generator.uniform(0.1, 1.5, LANES), generator.uniform(-1.5, 1.5, LANES)], axis=1)
    values[0] = 0.5, 0.5
    expected = np.stack([np.asarray(function(value)).ravel() for value in values])
    np.testing.assert_allclose(evaluated(function, values), expected, rtol=1e-12, atol=1e-14)
