"""A CasADi function compiled for arrays of points, with vectors whose lanes are points."""

import ctypes
from collections.abc import Callable, Sequence
from functools import lru_cache

import casadi as ca
import numpy as np

from repro.codegen.c_library import CompilerError, load_library
from repro.codegen.c_source import c_source
from repro.codegen.lanes import CONSTANT, FAST, FUNCTIONS, TYPE, block, vectorised

LEAST_POINTS = 8000  # below this a compiler takes longer than CasADi's own evaluation
LEAST_WORK = 2_000_000  # instructions at all points together
MOST_INSTRUCTIONS = 6000
LONG = 8000  # instructions: above it the compiler optimises little, which takes a fraction of the time

PointFunction = Callable[[Sequence[np.ndarray], np.ndarray], None]  # arrays (point, n_i) or (n_i,); result (point, ...)


def pays(function: ca.Function, points: int) -> bool:
    """Whether to compile a function for so many points."""
    size = function.n_instructions() if function.is_a("SXFunction") else 0
    dense = size > 0 and function.sparsity_out(0).is_dense()
    return dense and size <= MOST_INSTRUCTIONS and points >= LEAST_POINTS and points * size >= LEAST_WORK


def flags(function: ca.Function) -> Sequence[str]:
    """For the compiler, by the length of a function."""
    return ("-O1", *FAST[1:]) if function.n_instructions() > LONG else FAST


@lru_cache(maxsize=64)
def point_function(function: ca.Function, constant: tuple[bool, ...]) -> PointFunction | None:
    """A dense function in C, or None where it cannot be compiled; constant: which inputs are the same at all points."""
    names = [f"{CONSTANT}{i}" if same else f"given{i}" for i, same in enumerate(constant)]
    sizes = [function.numel_in(i) for i in range(function.n_in())]
    varying = [(i, name, sizes[i]) for i, name in enumerate(names) if sizes[i] and not constant[i]]
    load = (f"{name}[{k}][l] = given[{i}][{size} * at + {k}];" for i, name, size in varying for k in range(size))
    try:
        text = c_source(
            __file__,
            "point_function",
            outputs=function.numel_out(0),
            constants=" ".join(f"const double *{name} = given[{i}];" for i, name in enumerate(names) if constant[i]),
            arrays="".join(f"{name}[{size}], " for _, name, size in varying),
            load=" ".join(load),
            **block(*vectorised(function, "out", names)),
        )
        library = load_library(TYPE + FUNCTIONS + text, flags(function))
    except (ValueError, CompilerError, OSError):
        return None

    def run(arrays: Sequence[np.ndarray], result: np.ndarray) -> None:
        pointers = (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
        library.at_points(pointers, ctypes.c_int64(len(result)), ctypes.c_void_p(result.ctypes.data))

    return run
