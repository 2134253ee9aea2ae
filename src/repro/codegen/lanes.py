"""Straight-line statements over vectors of samples: each lane is a sample."""

import re
from collections.abc import Sequence

import casadi

from repro.codegen.straight_line import statements

LANES = 8


# of vectors of lanes, whose type and number are said before
FUNCTIONS = """
static inline vec splat(double x) { vec r; for (int l = 0; l < LANES; l++) r[l] = x; return r; }
#define UNARY(name, expression) \\
  static inline vec v_##name(vec a) { vec r; for (int l = 0; l < LANES; l++) r[l] = expression; return r; }
#define BINARY(name, expression) \\
  static inline vec v_##name(vec a, vec b) { vec r; for (int l = 0; l < LANES; l++) r[l] = expression; return r; }
UNARY(exp, exp(a[l])) UNARY(log, log(a[l])) UNARY(log1p, log1p(a[l])) UNARY(sin, sin(a[l])) UNARY(cos, cos(a[l]))
UNARY(tan, tan(a[l])) UNARY(tanh, tanh(a[l])) UNARY(fabs, fabs(a[l])) UNARY(sqrt, sqrt(a[l]))
UNARY(sign, (a[l] > 0) - (a[l] < 0)) UNARY(negation, a[l] == 0)
BINARY(less, a[l] < b[l]) BINARY(less_equal, a[l] <= b[l]) BINARY(equal, a[l] == b[l])
BINARY(unequal, a[l] != b[l]) BINARY(if_else_zero, a[l] != 0 ? b[l] : 0)
BINARY(fmax, fmax(a[l], b[l])) BINARY(fmin, fmin(a[l], b[l])) BINARY(pow, pow(a[l], b[l]))
"""


def vectorised(function: casadi.Function, output: str, inputs: Sequence[str]) -> tuple[list[str], int]:
    """Statements over lanes, and how many work variables w0, w1, ... they need; `parameters` are scalars."""
    lines, n_work = statements(function, inputs, output)
    return [_vector_statement(line, output) for line in lines], n_work


def _vector_statement(line: str, output: str) -> str:
    # scalars instead of an array of work variables: these stay in registers
    target, value = re.sub(r"\bw\[(\d+)\]", r"w\1", line).split(" = ", 1)
    if value.startswith("parameters[") or re.fullmatch(r"-?[\d.e+-]+", value):
        value = f"splat({value})"
    value = re.sub(r"\b([a-z_0-9]+)\(", lambda m: m[0] if m[1] == "splat" else f"v_{m[1]}(", value)
    return f"{target} {'+=' if output == 'sum' and target.startswith('sum[') else '='} {value}"
