"""Straight-line statements over vectors in C: each lane of a vector is one sample, or one stage of a horizon."""

import re
from collections.abc import Sequence
from functools import lru_cache

import casadi as ca

from repro.codegen.c_library import CompilerError, load_library
from repro.codegen.straight_line import CONSTANTS, OF_MATH_H, OWN_FUNCTIONS, statements

LANES = 8  # doubles in the widest vector registers; a compiler splits a vector for narrower ones
CONSTANT = "parameters"  # begins the name of an input that holds scalars, every other one holds vectors
FAST = ("-O3", "-march=native", "-ffast-math", "-mprefer-vector-width=512")  # for the compiler

TYPE = f"""
#include <math.h>
#include <stdint.h>
#define LANES {LANES}
typedef double vec __attribute__((vector_size(8 * LANES)));
"""

_OF_ONE = {name: f"{name}({{a}})" for name in OF_MATH_H}
_OF_ONE |= {name: body for name, body in OWN_FUNCTIONS.items() if "{b}" not in body}
_OF_TWO = {name: f"{name}({{a}}, {{b}})" for name in ("pow", "fmax", "fmin", "atan2")}
_OF_TWO |= {name: body for name, body in OWN_FUNCTIONS.items() if "{b}" in body}


def _lanewise(name: str, arguments: str, body: str) -> str:
    loop = f"for (int l = 0; l < LANES; l++) r[l] = {body.format(a='a[l]', b='b[l]')};"
    return f"static inline vec {name}({arguments}) {{ vec r; {loop} return r; }}"


# for any `vec` and LANES defined before
FUNCTIONS = "\n".join(
    [
        *CONSTANTS,
        # a loop over lanes is compiled to one load per lane
        "static inline vec splat(double a) { return a - (vec){0}; }",
        *(_lanewise(f"v_{name}", "vec a", body) for name, body in _OF_ONE.items()),
        *(_lanewise(f"v_{name}", "vec a, vec b", body) for name, body in _OF_TWO.items()),
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
