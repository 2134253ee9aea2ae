"""The integrators behind `simulate`: C, compiled once and kept on disk; without a compiler CasADi's virtual machine."""

import ctypes
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from repro.codegen import straight_line
from repro.codegen.c_library import load_library
from repro.codegen.c_source import c_source
from repro.codegen.straight_line import INPUTS, OUTPUT
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.substeps import SubstepRule


class CompiledIntegrator:
    """One compiled acceleration; see `simulate` for what the arguments mean."""

    def __init__(self, statements: Sequence[str], n_work: int, n_q: int, n_u: int) -> None:
        accelerate = straight_line.function("accelerate", INPUTS, OUTPUT, statements, n_work)
        sizes = f"#define N_Q {n_q}\n#define N_U {n_u}\n"
        source = f"{straight_line.preamble()}\n{sizes}{accelerate}{c_source(__file__, 'runge_kutta')}"
        self._simulate = load_library(source, straight_line.flags(statements)).simulate
        whole, real, array = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
        self._simulate.argtypes = [whole, whole, real, array, array, whole, array, whole, real, real, real, array]
        self._simulate.restype = None

    def __call__(self, rule: SubstepRule, u: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]; every array is contiguous."""
        angles = np.array(rule.angles, dtype=np.int64)
        self._simulate(
            *u.shape[:2],
            rule.time_step,
            u.ctypes.data,
            parameters.ctypes.data,
            parameters.shape[1] if len(parameters) > 1 else 0,
            angles.ctypes.data,
            len(angles),
            rule.least,
            rule.most,
            rule.per_rate,
            states.ctypes.data,
        )


class InterpretedIntegrator:
    """One interpreted acceleration; see `simulate` for what the arguments mean."""

    def __init__(self, acceleration: ca.Function) -> None:
        self._n_x = 2 * acceleration.numel_out(0)
        self._step = _step(acceleration)
        self._run = lru_cache(maxsize=256)(self._steps)

    def __call__(self, rule: SubstepRule, u: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]."""
        batch, steps, n_u = u.shape
        n_x = self._n_x
        weights = np.broadcast_to(parameters, (batch, parameters.shape[1]))
        column, following = np.empty(n_x + n_u + 1 + weights.shape[1]), np.empty(n_x + n_u + 1 + weights.shape[1])
        alive = np.arange(batch)
        for k in range(steps):
            counts = rule.substeps(states[alive, k])
            states[alive[counts == 0], k + 1 :] = np.nan
            alive, counts = alive[counts > 0], counts[counts > 0]
            for b, count in zip(alive.tolist(), counts.tolist(), strict=True):
                column[:n_x] = states[b, k]
                column[n_x : n_x + n_u] = u[b, k]
                column[n_x + n_u] = rule.time_step / count
                column[n_x + n_u + 1 :] = weights[b]
                buffer, run = self._run(count)
                buffer.set_arg(0, column.data)
                buffer.set_res(0, following.data)
                run()
                states[b, k + 1] = following[:n_x]
            reached = states[alive, k + 1]
            states[alive, k + 1] = np.where(np.isfinite(reached).all(axis=1, keepdims=True), reached, np.nan)

    def _steps(self, count: int) -> tuple[Any, Callable[[], None]]:
        return self._step.fold(count).buffer()


def _step(acceleration: ca.Function) -> ca.Function:
    """[x; u; h; parameters] after one Runge-Kutta step of x, the rest unchanged: a function that can be repeated."""
    n_q = acceleration.numel_out(0)
    x, u, h = ca.SX.sym("x", 2 * n_q), ca.SX.sym("u", acceleration.numel_in(2)), ca.SX.sym("h")
    parameters = ca.SX.sym("parameters", acceleration.numel_in(3))

    def rate(at: ca.SX) -> ca.SX:
        return ca.vertcat(at[n_q:], acceleration(at[:n_q], at[n_q:], u, parameters))

    column = ca.vertcat(x, u, h, parameters)
    return ca.Function("step", [column], [ca.vertcat(rk4_step(rate, x, h), u, h, parameters)])
