"""Who is compared: a name for the tables, and a training step made for a case."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from repro.bench.case import Case, Equation, lagrangian_case
from repro.bench.comparison import Comparison
from repro.bench.memory import peak_mib
from repro.bench.naive import naive_step, t2_features
from repro.bench.pairing import Pairs, interleaved
from repro.bench.scale import Hidden, Scale
from repro.bench.step import Step, native_step, torch_step
from repro.codegen.c_library import has_compiler
from repro.models.bases import t2

STEP = (
    "processor time of loss and gradient of one batch of {batch} samples, float64, n_q = 2, one thread; "
    "in turn, {{pairs}} pairs"
)
PREPARED = "; ours with the derivatives of the features prepared beforehand"


@dataclass(frozen=True)
class Contender:
    """A label, and a step for a case; `case` where it is not the one that both work on."""

    label: str
    step: Callable[[Case], Step]
    case: Callable[[], Case] | None = None


def in_torch(equation: Equation) -> Contender:
    """Our way without a compiler."""
    return Contender(f"{equation}, torch", partial(torch_step, equation=equation))


def fastest(equation: Equation) -> Contender:
    """Our way: compiled, where a compiler is there."""
    if not has_compiler():
        return in_torch(equation)
    return Contender(f"{equation}, compiled", partial(native_step, equation=equation))


def by_hessian(equation: Equation) -> Contender:
    """The usual way for the basis T2."""
    return Contender(f"{equation}, vmap(hessian)", partial(naive_step, equation=equation, features=t2_features))


def t2_case(hidden: Hidden, members: int, batch: int) -> Callable[[], Case]:
    """Networks of the paper's basis T2/V1 on the single pendulum."""
    return partial(lagrangian_case, t2, hidden, members, batch)


def size_text(hidden: Hidden) -> str:
    """Layers x width, e.g. 2x64."""
    return f"{len(hidden)}x{hidden[0]}"


def compared(
    scale: Scale,
    name: str,
    size: str,
    case: Callable[[], Case],
    pair: tuple[Contender, Contender],
    protocol: str,
    members: int = 1,
) -> Comparison:
    """A comparison of two steps, of which nothing is built before it is measured."""

    def measure() -> Pairs:
        built = case()
        steps = [one.step(built if one.case is None else one.case()) for one in pair]
        return interleaved(steps[0], steps[1], scale.rounds).with_memory(*map(peak_mib, steps))

    return Comparison(name, pair[0].label, pair[1].label, size, members, protocol, measure)
