"""The simulator for machines without a C compiler: an interpreter of the function's instructions, through numba.

One interpreter serves every function, so that nothing is compiled per model; numba keeps it between processes.
"""

import math
from enum import IntEnum

import casadi as ca
import numba
import numpy as np

from repro.codegen.straight_line import untranslated
from repro.mechanics.substeps import SubstepRule

# own numbers: what numba keeps on disk must not depend on the numbers of one CasADi version
Operation = IntEnum(
    "Operation",
    "MUL ADD SUB DIV POW CONSTPOW FMAX FMIN ATAN2 IF_ELSE_ZERO LT LE EQ NE AND OR ASSIGN NEG SQ TWICE INV "
    "SIN COS TANH EXP LOG LOG1P EXPM1 SQRT FABS SIGN NOT TAN SINH COSH ATAN CONST OUTPUT INPUT",
)
_NUMBERS = {getattr(ca, f"OP_{operation.name}"): operation.value for operation in Operation}

# numpy's error model: a division by zero gives inf, as in C; the cache knows this file alone, so all of it is here
_jit = numba.njit(error_model="numpy", cache=True)


class InterpretedIntegrator:
    """The instructions of one acceleration; see `simulate` for what the arguments mean."""

    def __init__(self, acceleration: ca.Function) -> None:
        self._instructions, self._constants = _tape(acceleration)
        self._work = acceleration.sz_w()

    def __call__(self, rule: SubstepRule, tau: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]."""
        bounds = (float(rule.time_step), float(rule.least), float(rule.most), float(rule.per_rate))
        angles = np.array(rule.angles, dtype=np.int64)
        _simulate(self._instructions, self._constants, self._work, bounds, angles, tau, parameters, states)


def _tape(function: ca.Function) -> tuple[np.ndarray, np.ndarray]:
    """Return instructions (n, 4) = [operation, target, first, second] and constants (n,) of a function.

    An input's first and second are the argument and the component. ValueError for an operation without translation.
    """
    rows, constants = [], np.zeros(function.n_instructions())
    for k in range(len(constants)):
        operation = function.instruction_id(k)
        first, second = (*function.instruction_input(k), 0, 0)[:2]
        target = function.instruction_output(k)[-1]
        if operation == ca.OP_CONST:
            constants[k] = function.instruction_constant(k)
        if operation not in _NUMBERS:
            raise untranslated(function, operation)
        rows.append((_NUMBERS[operation], target, first, second))
    return np.array(rows, dtype=np.int64), constants


@_jit
def _simulate(instructions, constants, n_work, rule, angles, tau, parameters, states) -> None:  # type: ignore[no-untyped-def]
    time_step, least, most, per_rate = rule
    n_q, n_x = tau.shape[2], 2 * tau.shape[2]
    k1, k2, k3, k4, at = np.empty(n_x), np.empty(n_x), np.empty(n_x), np.empty(n_x), np.empty(n_x)
    w = np.empty(n_work)
    for b in range(tau.shape[0]):
        own = parameters[b if len(parameters) > 1 else 0]
        for k in range(tau.shape[1]):
            x, following, held = states[b, k], states[b, k + 1], tau[b, k]
            n = least
            for i in angles:
                n = max(n, np.ceil(per_rate * abs(x[n_q + i])))
            if not np.all(np.isfinite(x)) or n > most:
                states[b, k + 1 :] = np.nan
                break
            following[:] = x
            for _ in range(int(n)):
                h = time_step / n
                _derivative(instructions, constants, following, held, own, w, k1)
                for i in range(n_x):
                    at[i] = following[i] + 0.5 * h * k1[i]
                _derivative(instructions, constants, at, held, own, w, k2)
                for i in range(n_x):
                    at[i] = following[i] + 0.5 * h * k2[i]
                _derivative(instructions, constants, at, held, own, w, k3)
                for i in range(n_x):
                    at[i] = following[i] + h * k3[i]
                _derivative(instructions, constants, at, held, own, w, k4)
                for i in range(n_x):
                    following[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            if not np.all(np.isfinite(following)):
                states[b, k + 1 :] = np.nan
                break


@_jit
def _derivative(  # type: ignore[no-untyped-def] # noqa: PLR0912, PLR0915 (a dispatch is long and flat)
    instructions, constants, x, tau, parameters, w, slope
) -> None:
    """Write the derivative of x = [q, qd] to slope; w is scratch. One flat chain, which compiles to a jump table."""
    n_q = len(tau)
    for i in range(n_q):
        slope[i] = x[n_q + i]
    for k in range(len(instructions)):
        operation, target = instructions[k, 0], instructions[k, 1]
        a, b = instructions[k, 2], instructions[k, 3]
        if operation == Operation.MUL:
            w[target] = w[a] * w[b]
        elif operation == Operation.ADD:
            w[target] = w[a] + w[b]
        elif operation == Operation.SUB:
            w[target] = w[a] - w[b]
        elif operation == Operation.DIV:
            w[target] = w[a] / w[b]
        elif operation in (Operation.POW, Operation.CONSTPOW):
            w[target] = math.pow(w[a], w[b])
        elif operation == Operation.FMAX:
            w[target] = w[a] if w[a] >= w[b] or math.isnan(w[b]) else w[b]
        elif operation == Operation.FMIN:
            w[target] = w[a] if w[a] <= w[b] or math.isnan(w[b]) else w[b]
        elif operation == Operation.ATAN2:
            w[target] = math.atan2(w[a], w[b])
        elif operation == Operation.IF_ELSE_ZERO:
            w[target] = w[b] if w[a] != 0.0 else 0.0
        elif operation == Operation.LT:
            w[target] = 1.0 if w[a] < w[b] else 0.0
        elif operation == Operation.LE:
            w[target] = 1.0 if w[a] <= w[b] else 0.0
        elif operation == Operation.EQ:
            w[target] = 1.0 if w[a] == w[b] else 0.0
        elif operation == Operation.NE:
            w[target] = 1.0 if w[a] != w[b] else 0.0
        elif operation == Operation.AND:
            w[target] = 1.0 if w[a] != 0.0 and w[b] != 0.0 else 0.0
        elif operation == Operation.OR:
            w[target] = 1.0 if w[a] != 0.0 or w[b] != 0.0 else 0.0
        elif operation == Operation.ASSIGN:
            w[target] = w[a]
        elif operation == Operation.NEG:
            w[target] = -w[a]
        elif operation == Operation.SQ:
            w[target] = w[a] * w[a]
        elif operation == Operation.TWICE:
            w[target] = 2.0 * w[a]
        elif operation == Operation.INV:
            w[target] = 1.0 / w[a]
        elif operation == Operation.SIN:
            w[target] = math.sin(w[a])
        elif operation == Operation.COS:
            w[target] = math.cos(w[a])
        elif operation == Operation.TANH:
            w[target] = math.tanh(w[a])
        elif operation == Operation.EXP:
            w[target] = math.exp(w[a])
        elif operation == Operation.LOG:
            w[target] = math.log(w[a])
        elif operation == Operation.LOG1P:
            w[target] = math.log1p(w[a])
        elif operation == Operation.EXPM1:
            w[target] = math.expm1(w[a])
        elif operation == Operation.SQRT:
            w[target] = math.sqrt(w[a])
        elif operation == Operation.FABS:
            w[target] = math.fabs(w[a])
        elif operation == Operation.SIGN:
            w[target] = (1.0 if w[a] > 0.0 else 0.0) - (1.0 if w[a] < 0.0 else 0.0)
        elif operation == Operation.NOT:
            w[target] = 1.0 if w[a] == 0.0 else 0.0
        elif operation == Operation.TAN:
            w[target] = math.tan(w[a])
        elif operation == Operation.SINH:
            w[target] = math.sinh(w[a])
        elif operation == Operation.COSH:
            w[target] = math.cosh(w[a])
        elif operation == Operation.ATAN:
            w[target] = math.atan(w[a])
        elif operation == Operation.CONST:
            w[target] = constants[k]
        elif operation == Operation.OUTPUT:
            slope[n_q + target] = w[a]
        elif a < 2:
            w[target] = x[a * n_q + b]
        elif a == 2:
            w[target] = tau[b]
        else:
            w[target] = parameters[b]
