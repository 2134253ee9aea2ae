"""The integrators behind `simulate`: C, compiled once and kept on disk; without a compiler CasADi's virtual machine."""

import ctypes
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from repro.codegen import straight_line
from repro.codegen.c_library import load_library
from repro.codegen.c_source import c_source
from repro.codegen.straight_line import INPUTS, OUTPUT
from repro.mechanics.runge_kutta import rk4_step

LEAST = 10  # sub-steps for one angle
MOST = 2000
ANGLE = 0.06  # rad per sub-step for one angle: the energy balance of a step holds within 1e-4 J, also at 100 rad/s
CHAIN_EXPONENT = 1.5  # outer links of a chain turn faster: both bounds grow with this power of the number of links


@dataclass(frozen=True)
class SubstepRule:
    """Sub-steps of one step of time_step s: ceil(per_rate * fastest rate among `angles`), at least `least`.

    A trajectory that would need more than `most` is given up: its states are NaN from there on.
    """

    time_step: float
    angles: tuple[int, ...]
    least: float
    most: float
    per_rate: float

    @classmethod
    def for_angles(cls, time_step: float, angles: Sequence[int]) -> "SubstepRule":
        """As many sub-steps as keep the turn of every angle within one of them below ANGLE."""
        finer = max(1, len(angles)) ** CHAIN_EXPONENT
        return cls(time_step, tuple(angles), math.ceil(LEAST * finer), MOST, finer * time_step / ANGLE)

    def substeps(self, states: np.ndarray) -> np.ndarray:
        """Number of sub-steps (batch,) from states (batch, 2 n_q) = [q, qd]; 0 where a trajectory is given up."""
        rates = np.abs(states[:, [states.shape[1] // 2 + i for i in self.angles]])
        counts = np.maximum(self.least, np.ceil(self.per_rate * rates.max(axis=1, initial=0.0)))
        followed = np.isfinite(states).all(axis=1) & (counts <= self.most)
        return np.where(followed, counts, 0).astype(int)


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
        stride = parameters.shape[1] if len(parameters) > 1 else 0
        given = (u.ctypes.data, parameters.ctypes.data, stride, angles.ctypes.data, len(angles))
        bounds = (rule.least, rule.most, rule.per_rate)
        self._simulate(*u.shape[:2], rule.time_step, *given, *bounds, states.ctypes.data)


class InterpretedIntegrator:
    """One interpreted acceleration; see `simulate` for what the arguments mean."""

    def __init__(self, acceleration: ca.Function) -> None:
        step = _step(acceleration)
        # Two columns, so that a sub-step from one to the other copies nothing.
        self._columns = np.zeros(step.numel_in(0)), np.zeros(step.numel_in(0))
        self._buffers: list[Any] = [step.buffer(), step.buffer()]
        for (buffer, _), given, reached in zip(self._buffers, self._columns, reversed(self._columns), strict=True):
            buffer.set_arg(0, given.data)
            buffer.set_res(0, reached.data)

    def __call__(self, rule: SubstepRule, u: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]."""
        n_x, n_u = states.shape[2], u.shape[2]
        x, held, h, weights = np.split(self._columns[0], [n_x, n_x + n_u, n_x + n_u + 1])
        given = np.broadcast_to(parameters, (len(u), parameters.shape[1]))
        (_, there), (_, back) = self._buffers
        for k in range(u.shape[1]):
            counts = rule.substeps(states[:, k])
            if not counts.any():  # nothing is left to follow
                states[:, k + 1 :] = np.nan
                break
            for b, count in enumerate(counts.tolist()):
                if count == 0:
                    states[b, k + 1] = np.nan
                    continue
                x[:], held[:], h[:], weights[:] = states[b, k], u[b, k], rule.time_step / count, given[b]
                for _ in range(count // 2):
                    there()
                    back()
                if count % 2:
                    there()
                states[b, k + 1] = self._columns[count % 2][:n_x]
            states[~np.isfinite(states[:, k + 1]).all(axis=1), k + 1] = np.nan


def _step(acceleration: ca.Function) -> ca.Function:
    """[x; u; h; parameters] after one Runge-Kutta step of x, the rest unchanged."""
    n_q = acceleration.numel_out(0)
    x, u, h = ca.SX.sym("x", 2 * n_q), ca.SX.sym("u", acceleration.numel_in(2)), ca.SX.sym("h")
    parameters = ca.SX.sym("parameters", acceleration.numel_in(3))

    def rate(at: ca.SX) -> ca.SX:
        return ca.vertcat(at[n_q:], acceleration(at[:n_q], at[n_q:], u, parameters))

    column = ca.vertcat(x, u, h, parameters)
    return ca.Function("step", [column], [ca.vertcat(rk4_step(rate, x, h), u, h, parameters)])
