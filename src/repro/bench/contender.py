"""The contenders of a comparison: a label for the tables, and a training step made for a case."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from repro.bench.naive import naive_step, t2_features
from repro.bench.pairing import PairedComparison, Pairs, with_memory
from repro.bench.scale import BenchScale, Hidden
from repro.bench.training_case import (
    Equation,
    Precision,
    Step,
    TrainingCase,
    native_step,
    network,
    pendulum_case,
    torch_step,
)
from repro.codegen.c_library import has_compiler
from repro.models.bases import t2

STEP = (
    "processor time of loss and gradient of one batch of {batch} samples, {precision}, {states}one thread; "
    "in turn, {{pairs}} pairs"
)
PREPARED = "; ours with the derivatives of the features prepared beforehand"


@dataclass(frozen=True)
class Contender:
    """A label, and a step for a case; `case` replaces the one that both would share."""

    label: str
    step: Callable[[TrainingCase], Step]
    case: Callable[[], TrainingCase] | None = None


def in_torch(equation: Equation) -> Contender:
    """This project without a compiler."""
    return Contender(f"{equation}, torch", partial(torch_step, equation=equation))


def fastest(equation: Equation, precision: Precision = "float64") -> Contender:
    """This project: compiled, where there is a compiler."""
    if not has_compiler():
        return in_torch(equation)
    label = f"{equation}, compiled" + (", float32" if precision == "float32" else "")
    return Contender(label, partial(native_step, equation=equation, precision=precision))


def by_hessian(equation: Equation) -> Contender:
    """The usual way for the basis T2."""
    return Contender(f"{equation}, vmap(hessian)", partial(naive_step, equation=equation, features=t2_features))


def size_text(hidden: Hidden) -> str:
    """Layers x width, e.g. 2x64."""
    return f"{len(hidden)}x{hidden[0]}"


def compared(
    scale: BenchScale,
    name: str,
    hidden: Hidden,
    ours: Contender,
    other: Contender,
    remark: str = "",
    *,
    members: int = 1,
    batch: int | None = None,
    precision: Precision = "float64",
    states: str = "n_q = 2, ",
) -> PairedComparison:
    """Two steps, built when measured, of networks on T2/V1 for the pendulum unless they have a case of their own."""
    size = scale.batch if batch is None else batch

    def measure() -> Pairs:
        shared = pendulum_case(network(t2, hidden), members, size)
        first, second = (one.step(shared if one.case is None else one.case()) for one in (ours, other))
        return with_memory(first, second, scale.rounds)

    protocol = STEP.format(batch=size, precision=precision, states=states) + remark
    return PairedComparison(name, ours.label, other.label, size_text(hidden), members, protocol, measure)
