"""The integrators behind `simulate`: C, compiled once and kept on disk; without a compiler CasADi's virtual machine."""

import ctypes
from collections.abc import Sequence
from functools import lru_cache

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
        self._steps = lru_cache(maxsize=256)(_step(acceleration).fold)  # the function of so many steps

    def __call__(self, rule: SubstepRule, u: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]."""
        weights = np.broadcast_to(parameters, (len(u), parameters.shape[1]))
        for b, forces in enumerate(u):
            for k, force in enumerate(forces):
                (count,) = rule.substeps(states[b, None, k]).tolist()
                if count == 0:
                    states[b, k + 1 :] = np.nan
                    break
                column = np.concatenate([states[b, k], force, [rule.time_step / count], weights[b]])
                reached = np.asarray(self._steps(count)(column))[: states.shape[2], 0]
                states[b, k + 1] = reached if np.isfinite(reached).all() else np.nan


def _step(acceleration: ca.Function) -> ca.Function:
    """[x; u; h; parameters] after one Runge-Kutta step of x, the rest unchanged: a function that can be repeated."""
    n_q = acceleration.numel_out(0)
    x, u, h = ca.SX.sym("x", 2 * n_q), ca.SX.sym("u", acceleration.numel_in(2)), ca.SX.sym("h")
    parameters = ca.SX.sym("parameters", acceleration.numel_in(3))

    def rate(at: ca.SX) -> ca.SX:
        return ca.vertcat(at[n_q:], acceleration(at[:n_q], at[n_q:], u, parameters))

    column = ca.vertcat(x, u, h, parameters)
    return ca.Function("step", [column], [ca.vertcat(rk4_step(rate, x, h), u, h, parameters)])
