"""This project's engine against the usual way of writing the Euler-Lagrange residual, and how its cost grows."""

from collections.abc import Iterator
from functools import partial

from repro.bench.comparison import PairedComparison
from repro.bench.contender import (
    PREPARED,
    STEP,
    Contender,
    by_hessian,
    compared,
    fastest,
    in_torch,
    size_text,
    t2_case,
)
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import random_case
from repro.codegen.c_library import has_compiler

ENSEMBLE = "; time of all members, by vmap(hessian) one after another"
GROWTH = "; random states, one network L(q, qd); the ratio is the growth of the cost from {least} coordinates"
MEMBERS = "; the ratio is the growth of the time of all members from one, over their number"


def engines(scale: BenchScale) -> Iterator[PairedComparison]:
    """Inverse steps of this engine, compiled and in torch, against vmap(hessian); then an ensemble.

    Large networks on the full batch too, but in one way only, because a naive step takes seconds.
    """
    ways = [fastest("inverse"), in_torch("inverse")] if has_compiler() else [in_torch("inverse")]
    for hidden in [*scale.sizes, *scale.large]:
        protocol, case = STEP.format(batch=scale.batch) + PREPARED, t2_case(hidden, 1, scale.batch)
        for own in ways[:1] if hidden in scale.large else ways:
            yield compared(scale, "engine", size_text(hidden), case, (own, by_hessian("inverse")), protocol)
    protocol, case = (
        STEP.format(batch=scale.batch) + ENSEMBLE + PREPARED,
        t2_case(PAPER_HIDDEN, scale.ensemble, scale.batch),
    )
    for own in ways:
        pair = own, by_hessian("inverse")
        yield compared(scale, "engine", size_text(PAPER_HIDDEN), case, pair, protocol, scale.ensemble)


def coordinates(scale: BenchScale) -> Iterator[PairedComparison]:
    """Growth of the inverse and of the forward step with n_q, for the smallest and the widest of the networks."""
    least, *more = scale.coordinates
    for hidden in dict.fromkeys([scale.sizes[0], scale.sizes[-1]]):
        protocol = STEP.format(batch=scale.batch).replace("n_q = 2, ", "") + GROWTH.format(least=least)
        for own in (fastest("inverse"), fastest("forward")):
            for n_q in more:
                first = Contender(f"{own.label}, n_q = {least}", own.step)
                other = Contender(f"n_q = {n_q}", own.step, partial(random_case, n_q, hidden, scale.batch))
                case = partial(random_case, least, hidden, scale.batch)
                yield compared(scale, "coordinates", size_text(hidden), case, (first, other), protocol)
