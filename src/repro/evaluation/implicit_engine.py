"""Implicit steps, solved by fixed-point iteration in generated C: each trajectory iterates for itself."""

import ctypes

import casadi
import numpy as np

from repro.codegen import c_maths
from repro.codegen.c_library import load_library
from repro.codegen.straight_line import statements

INPUTS = ("x", "guess", "parameters", "h")

_ITERATION = """
static int solve(const double *x, const double *move, const double *parameters, double h, double tolerance,
                 int64_t most, double *next) {
    double better[N_X], size = 1.0;
    for (int i = 0; i < N_X; i++) next[i] = x[i] + move[i], size = fmax(size, 1.0 + fabs(x[i]));
    for (int64_t k = 0; k < most; k++) {
        double change = 0.0;
        better_guess(x, next, parameters, &h, better);
        for (int i = 0; i < N_X; i++) {
            const double difference = fabs(better[i] - next[i]);
            if (!isfinite(difference)) return 0;
            change = fmax(change, difference);
            next[i] = better[i];
        }
        if (change <= tolerance * size) return 1;
    }
    return 0;
}

void integrate(int64_t batch, int64_t steps, double h, double tolerance, int64_t most, const double *parameters,
               int64_t n_parameters, double *states) {
    for (int64_t b = 0; b < batch; b++) {
        double move[N_X] = {0};
        for (int64_t k = 0; k < steps; k++) {
            double *x = states + (b * (steps + 1) + k) * N_X, *next = x + N_X;
            if (!solve(x, move, parameters + b * n_parameters, h, tolerance, most, next)) {
                for (int64_t i = 0; i < (steps - k) * N_X; i++) next[i] = nan;
                break;
            }
            for (int i = 0; i < N_X; i++) move[i] = next[i] - x[i];
        }
    }
}
"""


class FixedPoint:
    """One compiled step (x, guess of the next x, parameters, h) -> a better guess; CompilerError without a compiler."""

    def __init__(self, step: casadi.Function) -> None:
        lines, n_work = statements(step, INPUTS, "better")
        better_guess = c_maths.function("better_guess", INPUTS, "better", lines, n_work)
        source = f"{c_maths.PREAMBLE}\n#define N_X {step.numel_out(0)}\n{better_guess}{_ITERATION}"
        self._integrate = load_library(source, c_maths.flags(lines)).integrate
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
