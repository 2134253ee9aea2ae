"""Implicit steps, solved by fixed-point iteration in generated C: each trajectory iterates for itself."""

import ctypes

import casadi
import numpy as np

from repro.codegen import straight_line
from repro.codegen.c_library import load_library
from repro.codegen.c_source import c_source
from repro.codegen.straight_line import statements

INPUTS = ("x", "guess", "parameters", "h")


class FixedPoint:
    """One compiled step (x, guess of the next x, parameters, h) -> a better guess; CompilerError without a compiler."""

    def __init__(self, step: casadi.Function) -> None:
        lines, n_work = statements(step, INPUTS, "better")
        better_guess = straight_line.function("better_guess", INPUTS, "better", lines, n_work)
        sizes = f"#define N_X {step.numel_out(0)}\n"
        source = f"{straight_line.preamble()}\n{sizes}{better_guess}{c_source(__file__, 'fixed_point')}"
        self._integrate = load_library(source, straight_line.flags(lines)).integrate
        whole, real, array = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
        self._integrate.argtypes = [whole, whole, real, real, whole, array, whole, array]
        self._integrate.restype = None

    def __call__(
        self, states: np.ndarray, time_step: float, parameters: np.ndarray, tolerance: float, most: int
    ) -> None:
        """Fill states[:, 1:] (batch, steps + 1, n_x) from states[:, 0]; parameters (batch, n_parameters).

        A step is solved when it changes by less than `tolerance` of the state, in `most` iterations; where that fails
        the trajectory is NaN from there on.
        """
        weights = np.ascontiguousarray(parameters, dtype=float)
        batch, points, _ = states.shape
        self._integrate(
            batch, points - 1, time_step, tolerance, most, weights.ctypes.data, weights.shape[1], states.ctypes.data
        )
