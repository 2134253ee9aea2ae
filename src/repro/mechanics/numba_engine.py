"""The simulator through numba, for machines without a C compiler: the same statements, the same arithmetic."""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from repro.mechanics.pace import Pace
from repro.mechanics.straight_line import parts


class Integrator:
    """One compiled acceleration; see `simulate` for what the arguments mean."""

    def __init__(self, statements: Sequence[str], n_work: int, n_q: int) -> None:
        self._simulate = _simulator(_accelerate(statements), n_work, n_q)

    def __call__(self, pace: Pace, tau: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]."""
        numbers = (float(pace.time_step), float(pace.least), float(pace.most), float(pace.per_rate))
        self._simulate(numbers, np.array(pace.angles, dtype=np.int64), tau, parameters, states)


def _jit(function: Callable[..., Any]) -> Callable[..., Any]:
    import numba

    # numpy's error model: a division by zero gives inf, as in C
    return numba.njit(error_model="numpy")(function)


_NAMES = ("sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "tanh", "sinh", "cosh", "atan", "atan2", "fabs")


@lru_cache(maxsize=1)
def _functions() -> dict[str, Any]:
    logic: dict[str, Callable[..., float]] = {
        "less": lambda a, b: 1.0 if a < b else 0.0,
        "less_equal": lambda a, b: 1.0 if a <= b else 0.0,
        "equal": lambda a, b: 1.0 if a == b else 0.0,
        "unequal": lambda a, b: 1.0 if a != b else 0.0,
        "both": lambda a, b: 1.0 if a != 0.0 and b != 0.0 else 0.0,
        "either": lambda a, b: 1.0 if a != 0.0 or b != 0.0 else 0.0,
        "negation": lambda a: 1.0 if a == 0.0 else 0.0,
        "if_else_zero": lambda a, b: b if a != 0.0 else 0.0,
        "sign": lambda a: 1.0 if a > 0.0 else (-1.0 if a < 0.0 else 0.0),
        # as in C, a NaN gives way to the other argument
        "fmax": lambda a, b: a if a >= b or math.isnan(b) else b,
        "fmin": lambda a, b: a if a <= b or math.isnan(b) else b,
    }
    known = {name: getattr(math, name) for name in (*_NAMES, "inf", "nan")}
    return known | {name: _jit(rule) for name, rule in logic.items()}


def _accelerate(statements: Sequence[str]) -> Callable[..., Any]:
    namespace = dict(_functions())
    calls = []
    for i, lines in enumerate(parts(statements)):
        _define(f"part{i}", lines, namespace)
        calls.append(f"part{i}(q, qd, tau, parameters, qdd, w)")
    _define("accelerate", calls, namespace)
    return namespace["accelerate"]


def _define(name: str, lines: Sequence[str], namespace: dict[str, Any]) -> None:
    exec("\n    ".join([f"def {name}(q, qd, tau, parameters, qdd, w):", *lines]), namespace)
    namespace[name] = _jit(namespace[name])


def _simulator(accelerate: Callable[..., Any], n_work: int, n_q: int) -> Callable[..., Any]:
    n_x = 2 * n_q

    @_jit
    def derivative(x: Any, tau: Any, parameters: Any, slope: Any, w: Any) -> None:
        slope[:n_q] = x[n_q:]
        accelerate(x[:n_q], x[n_q:], tau, parameters, slope[n_q:], w)

    @_jit
    def rk4(x: Any, tau: Any, parameters: Any, h: float, work: Any) -> None:
        k1, k2, k3, k4, at, w = work
        derivative(x, tau, parameters, k1, w)
        for i in range(n_x):
            at[i] = x[i] + 0.5 * h * k1[i]
        derivative(at, tau, parameters, k2, w)
        for i in range(n_x):
            at[i] = x[i] + 0.5 * h * k2[i]
        derivative(at, tau, parameters, k3, w)
        for i in range(n_x):
            at[i] = x[i] + h * k3[i]
        derivative(at, tau, parameters, k4, w)
        for i in range(n_x):
            x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])

    @_jit
    def simulate(pace: Any, angles: Any, tau: Any, parameters: Any, states: Any) -> None:
        time_step, least, most, per_rate = pace
        work = (np.empty(n_x), np.empty(n_x), np.empty(n_x), np.empty(n_x), np.empty(n_x), np.empty(n_work))
        for b in range(tau.shape[0]):
            own = parameters[b if len(parameters) > 1 else 0]
            for k in range(tau.shape[1]):
                x, following = states[b, k], states[b, k + 1]
                n = least
                for i in angles:
                    n = max(n, math.ceil(per_rate * abs(x[n_q + i])))
                if not np.all(np.isfinite(x)) or n > most:
                    states[b, k + 1 :] = np.nan
                    break
                following[:] = x
                for _ in range(int(n)):
                    rk4(following, tau[b, k], own, time_step / n, work)
                if not np.all(np.isfinite(following)):
                    states[b, k + 1 :] = np.nan
                    break

    return simulate
