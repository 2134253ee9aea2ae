"""Straight-line statements over vectors in C: each lane of a vector is one sample, or one stage of a horizon."""

import re
from collections.abc import Sequence
from functools import lru_cache

import casadi as ca

from repro.codegen.c_library import CompilerError, load_library
from repro.codegen.straight_line import OF_MATH_H, statements

LANES = 8  # doubles in the widest vector registers; a compiler splits a vector for narrower ones
CONSTANT = "parameters"  # begins the name of an input that holds scalars, every other one holds vectors
FAST = ("-O3", "-march=native", "-ffast-math", "-mprefer-vector-width=512")  # for the compiler

TYPE = f"""
#include <math.h>
#include <stdint.h>
#define LANES {LANES}
typedef double vec __attribute__((vector_size(8 * LANES)));
"""

_BINARY = {
    **{name: f"{name}(a[l], b[l])" for name in ("pow", "fmax", "fmin", "atan2")},
    "less": "a[l] < b[l]",
    "less_equal": "a[l] <= b[l]",
    "equal": "a[l] == b[l]",
    "unequal": "a[l] != b[l]",
    "both": "a[l] != 0.0 && b[l] != 0.0",
    "either": "a[l] != 0.0 || b[l] != 0.0",
    "if_else_zero": "a[l] != 0.0 ? b[l] : 0.0",
}
_UNARY = {name: f"{name}(a[l])" for name in OF_MATH_H}
_UNARY |= {"sign": "(a[l] > 0.0) - (a[l] < 0.0)", "negation": "a[l] == 0.0"}


def _lanewise(name: str, arguments: str, body: str) -> str:
    loop = f"for (int l = 0; l < LANES; l++) r[l] = {body};"
    return f"static inline vec {name}({arguments}) {{ vec r; {loop} return r; }}"


# for any `vec` and LANES defined before
FUNCTIONS = "\n".join(
    [
        "#define inf INFINITY",
        "#define nan NAN",
        # a loop over lanes is compiled to one load per lane
        "static inline vec splat(double a) { return a - (vec){0}; }",
        *(_lanewise(f"v_{name}", "vec a", body) for name, body in _UNARY.items()),
        *(_lanewise(f"v_{name}", "vec a, vec b", body) for name, body in _BINARY.items()),
        "",
    ]
)


def vectorised(function: ca.Function, output: str, inputs: Sequence[str]) -> tuple[list[str], int]:
    """Statements over lanes of output = function(*inputs), and the number of work variables w0, w1, ... they need.

    Inputs whose name begins with CONSTANT hold scalars, all others vectors. An output `sum` is added to, not replaced.
    """
    lines, n_work = statements(function, inputs, output)
    return [_vector_statement(line, output) for line in lines], n_work


def block(lines: Sequence[str], n_work: int) -> dict[str, str]:
    """Work variables and statements for a C file with ${work} and ${statements}."""
    work, text = (f"w{i}" for i in range(max(1, n_work))), "\n".join(f"    {line};" for line in lines)
    return {"work": ", ".join(work), "statements": text}


@lru_cache(maxsize=1)
def can_compile() -> bool:
    """Whether generated code can be compiled here; what a compiler that works refuses is a fault, and raises."""
    # a compiler without the C library's headers is common, and a processor may refuse the flags
    try:
        load_library("#include <math.h>\n#include <stdint.h>\n", FAST)
    except (CompilerError, OSError):
        return False
    return True


def vector_function(function: ca.Function, inputs: Sequence[str]) -> str:
    """`static void NAME(const vec *INPUT, ..., vec *restrict out)` for a function with one column as its result."""
    lines, n_work = vectorised(function, "out", inputs)
    arguments = "".join(f"const {'double' if name.startswith(CONSTANT) else 'vec'} *{name}, " for name in inputs)
    work = f"    vec {', '.join(f'w{i}' for i in range(n_work))};\n" if n_work else ""
    body = "".join(f"    {line};\n" for line in lines)
    name = function.name()
    return f"static __attribute__((noinline)) void {name}({arguments}vec *restrict out) {{\n{work}{body}}}\n"


def _vector_statement(line: str, output: str) -> str:
    # scalars instead of an array of work variables: these stay in registers
    target, value = re.sub(r"\bw\[(\d+)\]", r"w\1", line).split(" = ", 1)
    if value.startswith(CONSTANT) or _is_number(value):
        value = f"splat({value})"
    else:
        value = re.sub(r"^(\w+)\(", r"v_\1(", value)
    return f"{target} {'+=' if output == 'sum' and target.startswith('sum[') else '='} {value}"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
