"""What straight-line statements need in C: headers, constants, CasADi's comparisons; and functions made of parts."""

from collections.abc import Sequence

from repro.codegen.c_source import c_source
from repro.codegen.straight_line import parts


def preamble() -> str:
    """Headers, constants and comparisons that the statements of `straight_line` need."""
    return c_source(__file__, "scalar_functions")


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
