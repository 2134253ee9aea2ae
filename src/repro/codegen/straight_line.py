"""An SX function as straight-line C: statements, which operations the engines know, and functions made of parts."""

from collections.abc import Sequence

import casadi as ca

PART = 500
INPUTS = ("q", "qd", "u", "parameters")
OUTPUT = "qdd"
CONSTANTS = ("#define inf INFINITY", "#define nan NAN")  # as Python writes them

# of math.h, each with the name of CasADi's operation
OF_MATH_H = ("sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "tanh", "sinh", "cosh", "atan", "fabs")
_OF_TWO = {"POW": "pow", "CONSTPOW": "pow", "FMAX": "fmax", "FMIN": "fmin", "ATAN2": "atan2", "AND": "both"}
_OF_TWO |= {"LT": "less", "LE": "less_equal", "EQ": "equal", "NE": "unequal", "OR": "either"}
_OF_TWO |= {"IF_ELSE_ZERO": "if_else_zero"}
# what math.h lacks, of numbers a and b
OWN_FUNCTIONS = {
    "less": "{a} < {b}",
    "less_equal": "{a} <= {b}",
    "equal": "{a} == {b}",
    "unequal": "{a} != {b}",
    "both": "{a} != 0.0 && {b} != 0.0",
    "either": "{a} != 0.0 || {b} != 0.0",
    "if_else_zero": "{a} != 0.0 ? {b} : 0.0",
    "sign": "({a} > 0.0) - ({a} < 0.0)",
    "negation": "{a} == 0.0",
}
BINARY = {
    **{getattr(ca, f"OP_{name}"): f"{called}({{a}}, {{b}})" for name, called in _OF_TWO.items()},
    ca.OP_ADD: "{a} + {b}",
    ca.OP_SUB: "{a} - {b}",
    ca.OP_MUL: "{a} * {b}",
    ca.OP_DIV: "{a} / {b}",
}
UNARY = {
    **{getattr(ca, f"OP_{name.upper()}"): f"{name}({{a}})" for name in (*OF_MATH_H, "sign")},
    ca.OP_ASSIGN: "{a}",
    ca.OP_NEG: "-{a}",
    ca.OP_INV: "1.0 / {a}",
    ca.OP_SQ: "{a} * {a}",
    ca.OP_TWICE: "2.0 * {a}",
    ca.OP_NOT: "negation({a})",
}
_NAMES = {getattr(ca, name): name[3:].lower() for name in dir(ca) if name.startswith("OP_")}


def statements(function: ca.Function, inputs: Sequence[str] = INPUTS, output: str = OUTPUT) -> tuple[list[str], int]:
    """Return (statements, length of the work array w) of output = function(*inputs).

    A statement is `w[3] = sin(w[1])`, without a terminator; inputs read as q[0], the output is written to qdd[0].
    ValueError for a function that is not a scalar expression graph, or that uses an operation without a translation.
    """
    if not function.is_a("SXFunction"):
        raise ValueError(f"{function.name()} is not an SX function: expand() it first")
    lines = []
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        sources, targets = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_INPUT:
            lines.append(f"w[{targets[0]}] = {inputs[sources[0]]}[{sources[1]}]")
        elif operation == ca.OP_OUTPUT:
            lines.append(f"{output}[{targets[1]}] = w[{sources[0]}]")
        elif operation == ca.OP_CONST:
            lines.append(f"w[{targets[0]}] = {float(function.instruction_constant(k))!r}")
        elif operation in BINARY:
            lines.append(f"w[{targets[0]}] = " + BINARY[operation].format(a=f"w[{sources[0]}]", b=f"w[{sources[1]}]"))
        elif operation in UNARY:
            lines.append(f"w[{targets[0]}] = " + UNARY[operation].format(a=f"w[{sources[0]}]"))
        else:
            raise ValueError(f"operation {_NAMES[operation]!r} of {function.name()} has no translation")
    return lines, function.sz_w()


def parts(lines: Sequence[str]) -> list[Sequence[str]]:
    """Split statements into parts short enough that a compiler's time stays proportional to their number."""
    return [lines[start : start + PART] for start in range(0, len(lines), PART)]


def preamble() -> str:
    """Headers, constants and comparisons that the statements of `straight_line` need."""
    lines = ["#include <math.h>", "#include <stdint.h>", "#include <string.h>", *CONSTANTS]
    for name, body in OWN_FUNCTIONS.items():
        arguments = "double a, double b" if "{b}" in body else "double a"
        lines.append(f"static inline double {name}({arguments}) {{ return {body.format(a='a', b='b')}; }}")
    return "\n".join([*lines, ""])


def function(name: str, inputs: Sequence[str], output: str, lines: Sequence[str], n_work: int) -> str:
    """`static void name(const double *input, ..., double *output)` that runs the statements."""
    given = "".join(f"const double *{each}, " for each in inputs)
    divided = parts(lines)
    inline = "inline" if len(divided) == 1 else "__attribute__((noinline))"
    text = [
        f"static {inline} void {name}_{i}({given}double *restrict {output}, double *restrict w) {{\n"
        + "".join(f"    {line};\n" for line in each)
        + "}\n"
        for i, each in enumerate(divided)
    ]
    calls = "".join(f"    {name}_{i}({', '.join(inputs)}, {output}, w);\n" for i in range(len(divided)))
    text.append(
        f"static void {name}({given}double *restrict {output}) {{\n    double w[{max(1, n_work)}];\n{calls}}}\n"
    )
    return "\n".join(text)


def flags(lines: Sequence[str]) -> list[str]:
    """For the compiler; without contraction to fused multiply-add the result is the same on every machine."""
    return ["-O2" if len(parts(lines)) == 1 else "-O1", "-ffp-contract=off", "-fno-math-errno"]
