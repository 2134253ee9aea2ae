"""A CasADi function at many points: compiled where there is a compiler, interpreted otherwise."""

import ctypes
from collections.abc import Callable
from functools import lru_cache

import casadi as ca
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.codegen.c_library import CompilerError, load_library
from repro.codegen.c_source import c_source
from repro.codegen.lanes import FAST, FUNCTIONS, TYPE, vectorised

Evaluation = Callable[[np.ndarray, np.ndarray], np.ndarray]
LONG = 8000  # statements: above it a compiler is not asked to try hard


@lru_cache(maxsize=32)
def evaluation(function: ca.Function) -> Evaluation:
    """(points (n, n_in), parameters (n_p,)) -> (n, n_out), for a function (x, parameters) whose result is a column."""
    try:
        return _compiled(function)
    except (CompilerError, OSError):
        return lambda points, parameters: evaluate(function, points, parameters)


def _compiled(function: ca.Function) -> Evaluation:
    inputs, outputs = function.numel_in(0), function.numel_out(0)
    text = TYPE + FUNCTIONS + vector_function(function) + c_source(
        __file__, "compiled_evaluation", inputs=inputs, outputs=outputs
    )  # fmt: skip
    flags = ("-O1", *FAST[1:]) if function.n_instructions() > LONG else FAST
    run = load_library(text, flags).evaluate
    run.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p]
    run.restype = None

    def evaluated(points: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        given, weights = (np.ascontiguousarray(each, dtype=float) for each in (points, parameters))
        result = np.empty((len(given), outputs))
        run(given.ctypes.data, len(given), weights.ctypes.data, result.ctypes.data)
        return result

    return evaluated


def vector_function(function: ca.Function, name: str = "function") -> str:
    """`static void NAME(const vec *x, const double *parameters, vec *out)` for a function (x, parameters)."""
    lines, n_work = vectorised(function, "out", ("x", "parameters"))
    work = f"    vec {', '.join(f'w{i}' for i in range(n_work))};\n" if n_work else ""
    body = "".join(f"    {line};\n" for line in lines)
    arguments = "const vec *x, const double *parameters, vec *restrict out"
    return f"static __attribute__((noinline)) void {name}({arguments}) {{\n{work}{body}}}\n"
