"""Scalar CasADi functions as C that evaluates several stages at once, a lane of a vector each."""

import re
from collections.abc import Sequence

import casadi as ca

from repro.codegen.straight_line import statements

LANES = 8  # doubles of the widest vector registers; a compiler divides a vector for narrower ones
_SLOT = re.compile(r"w\[(\d+)\]")
_UNARY = ("sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "tanh", "sinh", "cosh", "atan", "fabs")
_BINARY = {"pow": "pow(a[i], b[i])", "fmax": "fmax(a[i], b[i])", "fmin": "fmin(a[i], b[i])"}
_BINARY |= {"atan2": "atan2(a[i], b[i])", "less": "a[i] < b[i]", "less_equal": "a[i] <= b[i]"}
_BINARY |= {"equal": "a[i] == b[i]", "unequal": "a[i] != b[i]", "both": "a[i] != 0.0 && b[i] != 0.0"}
_BINARY |= {"either": "a[i] != 0.0 || b[i] != 0.0", "if_else_zero": "a[i] != 0.0 ? b[i] : 0.0"}
_OWN = {"sign": "(a[i] > 0.0) - (a[i] < 0.0)", "negation": "a[i] == 0.0"}


def preamble() -> str:
    """The type `vec` of LANES doubles, and the functions of it that kernels call."""
    known = {name: f"{name}(a[i])" for name in _UNARY} | _OWN
    lines = [
        "#include <math.h>",
        f"#define LANES {LANES}",
        "#define inf INFINITY",
        "#define nan NAN",
        "typedef double vec __attribute__((vector_size(8 * LANES)));",
        "static inline vec spread(double a) { return a - (vec){0.0}; }",
    ]
    lines += [_lanewise(name, "vec a", body) for name, body in known.items()]
    lines += [_lanewise(name, "vec a, vec b", body) for name, body in _BINARY.items()]
    return "\n".join(lines) + "\n"


def kernel(function: ca.Function, inputs: Sequence[str]) -> str:
    """`static void NAME(const vec *INPUT, ..., vec *restrict out)` for a function with one column as its result."""
    lines, size = statements(function, inputs, "out")
    taken = "".join(f"const vec *{name}, " for name in inputs)
    slots = ", ".join(f"w{i}" for i in range(size))
    body = "\n".join(f"    {_statement(line)};" for line in lines)
    local = f"    vec {slots};\n" if size else ""
    return f"static __attribute__((noinline)) void {function.name()}({taken}vec *restrict out) {{\n{local}{body}\n}}\n"


def _statement(line: str) -> str:
    target, value = _SLOT.sub(r"w\1", line).split(" = ", 1)
    for name in (*_UNARY, *_OWN, *_BINARY):
        if value.startswith(f"{name}("):
            return f"{target} = each_{value}"
    return f"{target} = spread({value})" if _is_number(value) else f"{target} = {value}"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _lanewise(name: str, taken: str, body: str) -> str:
    loop = f"for (int i = 0; i < LANES; i++) r[i] = {body};"
    return f"static inline vec each_{name}({taken}) {{ vec r; {loop} return r; }}"
