"""Which comparisons answer claim C11: naive against naive, best against best, time to equal accuracy."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from types import ModuleType

from repro.bench.accuracy import GROWTH, Race
from repro.bench.case import Case, Equation, lagrangian_case, structured_case
from repro.bench.comparison import Comparison
from repro.bench.delan import delan_step
from repro.bench.naive import engineered_features, naive_step, t2_features
from repro.bench.pairing import Pairs, interleaved
from repro.bench.scale import PAPERS, SCALES, Hidden, Scale
from repro.bench.step import Step, native_step, torch_step
from repro.mechanics.c_library import has_compiler
from repro.models.bases import engineered, t2

FASTEST = "Levenberg-Marquardt"  # of the optimisers

STEP = (
    "processor time of loss and gradient of one batch of {batch} samples, float64, n_q = 2, one thread; "
    "in turn, {{pairs}} pairs"
)
ALIKE = "; the same network, weights, samples and way of computing"
PREPARED = "; ours with the derivatives of the features prepared beforehand"
ENSEMBLE = "; time of all members, by vmap(hessian) one after another"
DELAN = "; DeLaN written anew from its paper (softplus layers of q); ours: M of equal width from cos and sin, tanh"
LINN = "; LINN has no public code, so taken as one network of [q; qd; cos q; sin q], vmap(hessian), inverse loss"


@dataclass(frozen=True)
class Contender:
    """A name for the tables, and a training step made for a case."""

    label: str
    step: Callable[[Case], Step]


def comparisons(scale: str) -> list[Comparison]:
    """All comparisons of a scale, none of them measured yet."""
    chosen = SCALES[scale]
    return [
        *_forward_against_inverse(chosen),
        *_engines(chosen),
        *_against_delan(chosen),
        *_against_linn(chosen),
        *_time_to_accuracy(chosen),
    ]


def ours(hidden: Hidden, equation: Equation, model: str = "") -> list[Contender]:
    """Our engines that apply to a network: generated code for the paper's small one, where a compiler is there."""
    ways = {"jets": torch_step}
    if hidden == PAPERS and has_compiler():
        ways["generated code"] = native_step
    return [Contender(f"{equation}, {model}{way}", partial(step, equation=equation)) for way, step in ways.items()]


def size_text(hidden: Hidden) -> str:
    """Layers x width, e.g. 2x64."""
    return f"{len(hidden)}x{hidden[0]}"


def _forward_against_inverse(scale: Scale) -> Iterator[Comparison]:
    for hidden in [*scale.sizes, *scale.large]:
        batch = scale.large_batch if hidden in scale.large else scale.batch
        case = _lagrangian(t2, hidden, 1, batch)
        inverse, forward = ([_hessian(equation), *ours(hidden, equation)] for equation in ("inverse", "forward"))
        for pair in zip(inverse, forward, strict=True):
            yield _compared(scale, "forward_vs_inverse", hidden, case, pair, STEP.format(batch=batch) + ALIKE)


def _engines(scale: Scale) -> Iterator[Comparison]:
    protocol = STEP.format(batch=scale.batch)
    for hidden in scale.sizes:
        case = _lagrangian(t2, hidden, 1, scale.batch)
        for own in ours(hidden, "inverse"):
            yield _compared(scale, "engine", hidden, case, (own, _hessian("inverse")), protocol + PREPARED)
    case = _lagrangian(t2, PAPERS, scale.ensemble, scale.batch)
    for own in ours(PAPERS, "inverse"):
        pair = own, _hessian("inverse")
        yield _compared(scale, "engine", PAPERS, case, pair, protocol + ENSEMBLE + PREPARED, scale.ensemble)


def _against_delan(scale: Scale) -> Iterator[Comparison]:
    for hidden in scale.sizes:
        other = Contender("DeLaN (Lutter et al. 2019)", partial(delan_step, hidden=hidden))
        case = partial(structured_case, hidden, 1, scale.batch)
        for own in ours(hidden, "inverse", "structured M, "):
            protocol = STEP.format(batch=scale.batch) + PREPARED + DELAN
            yield _compared(scale, "inverse_vs_delan", hidden, case, (own, other), protocol)


def _against_linn(scale: Scale) -> Iterator[Comparison]:
    naive = partial(naive_step, equation="inverse", features=engineered_features)
    for hidden in scale.sizes:
        case = _lagrangian(engineered, hidden, 1, scale.batch)
        for own in ours(hidden, "inverse"):
            pair = own, Contender("LINN (Bao et al. 2021)", naive)
            protocol = STEP.format(batch=scale.batch) + PREPARED + LINN
            yield _compared(scale, "inverse_vs_linn", hidden, case, pair, protocol)


def _time_to_accuracy(scale: Scale) -> Iterator[Comparison]:
    size = scale.race
    race = Race(_lagrangian(t2, PAPERS, size.members, size.samples), size.threshold, size.patience, size.limit_s)
    protocol = (
        f"processor time of training from a random start to a training MAE_tau of {size.threshold:g}; one thread, "
        f"{size.samples} samples in episodes of 100 steps; budgets grow by {GROWTH:g}; {{pairs}} starts, one a pair; "
        "infinite: not reached "
    )
    named = partial(Comparison, "time_to_accuracy", size=size_text(PAPERS), members=1)
    for name in size.optimisers:
        yield named(
            ours=f"inverse, {name}",
            other=f"forward, {name}",
            protocol=f"{protocol}in {size.patience:g} times the seconds of the inverse objective",
            measure=partial(race.forward_against_inverse, name),
        )
    for name in size.optimisers:
        if name != FASTEST:
            yield named(
                ours=f"inverse, {FASTEST}",
                other=f"inverse, {name}",
                protocol=f"{protocol}in {size.limit_s:g} s",
                measure=partial(race.optimisers, FASTEST, name),
            )


def _hessian(equation: Equation) -> Contender:
    return Contender(f"{equation}, vmap(hessian)", partial(naive_step, equation=equation, features=t2_features))


def _lagrangian(basis: ModuleType, hidden: Hidden, members: int, batch: int) -> Callable[[], Case]:
    return partial(lagrangian_case, basis, hidden, members, batch)


def _compared(
    scale: Scale,
    name: str,
    hidden: Hidden,
    case: Callable[[], Case],
    pair: tuple[Contender, Contender],
    protocol: str,
    members: int = 1,
) -> Comparison:
    """A comparison of two steps on one case, of which nothing is built before it is measured."""

    def measure() -> Pairs:
        built = case()
        return interleaved(pair[0].step(built), pair[1].step(built), scale.rounds)

    return Comparison(name, pair[0].label, pair[1].label, size_text(hidden), members, protocol, measure)
