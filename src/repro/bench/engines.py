"""This project's engine against the usual way of writing the Euler-Lagrange residual, and how its cost grows."""

from collections.abc import Iterator
from functools import partial
from itertools import pairwise, product

import numpy as np
import torch

from repro.bench.contender import PREPARED, Contender, by_hessian, compared, fastest, in_torch
from repro.bench.pairing import PairedComparison, Rounds, with_memory
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import EPISODE_STEPS, TrainingCase, network, pendulum, pendulum_case, random_case
from repro.codegen.c_library import has_compiler
from repro.learning.optimisers.least_squares import regression, streamed_solve
from repro.models.bases import t1, t2
from repro.models.lagrangian import Lagrangian

BLOCK = 100_000
SAMPLES = (
    "processor time of simulating the single pendulum in episodes of {steps} steps and of least squares for T1/V1, "
    "by blocks of {block} samples, none of which is stored; one thread; the ratio is the growth of the time; "
    "{{pairs}} pairs"
)
MEMBERS = "; compiled where there is a compiler; the ratio is the growth of the time of all members"
ENSEMBLE = "; time of all members, by vmap(hessian) one after another"
GROWTH = "; random states, one network L(q, qd); the ratio is the growth of the cost from {least} coordinates"


def engines(scale: BenchScale) -> Iterator[PairedComparison]:
    """Inverse steps of this engine, compiled and in torch, against vmap(hessian); then an ensemble.

    Large networks on the full batch too, but in one way only, because a naive step takes seconds.
    """
    ways = [fastest("inverse"), in_torch("inverse")] if has_compiler() else [in_torch("inverse")]
    usual = by_hessian("inverse")
    for hidden in [*scale.sizes, *scale.large]:
        for own in ways[:1] if hidden in scale.large else ways:
            yield compared(scale, "engine", hidden, own, usual, PREPARED)
    for own in ways:
        yield compared(scale, "engine", PAPER_HIDDEN, own, usual, ENSEMBLE + PREPARED, members=scale.ensemble)


def coordinates(scale: BenchScale) -> Iterator[PairedComparison]:
    """Growth of the inverse and of the forward step with n_q, for the smallest and the widest of the networks."""
    least, *more = scale.coordinates
    for hidden in dict.fromkeys([scale.sizes[0], scale.sizes[-1]]):
        for own, n_q in product((fastest("inverse"), fastest("forward")), more):
            first, other = (
                Contender(f"{label}n_q = {size}", own.step, partial(random_case, size, hidden, scale.batch))
                for label, size in ((f"{own.label}, ", least), ("", n_q))
            )
            remark = GROWTH.format(least=least)
            yield compared(scale, "coordinates", hidden, first, other, remark, states="")


def samples(scale: BenchScale) -> Iterator[PairedComparison]:
    """Streamed least squares: from each number of samples to the next."""
    protocol = SAMPLES.format(steps=EPISODE_STEPS, block=BLOCK)
    rounds = Rounds(least=1, most=scale.rounds.most, limit_s=scale.rounds.limit_s)
    for less, more in pairwise([scale.streamed[0], *scale.streamed]):
        measure = partial(with_memory, partial(streamed, less), partial(streamed, more), rounds)
        yield PairedComparison("samples", f"{less:g} samples", f"{more:g} samples", "T1/V1", 1, protocol, measure)


def streamed(samples: int) -> np.ndarray:
    """The coefficients (4,) of T1/V1 from `samples` samples, simulated and used block by block."""
    model = Lagrangian(t1, 2)
    start = torch.zeros(1, model.n_parameters, dtype=torch.float64)
    sizes = (min(BLOCK, samples - begin) for begin in range(0, samples, BLOCK))
    cases = (TrainingCase(model, start, pendulum([number], size)) for number, size in enumerate(sizes))
    return streamed_solve((regression(case.problem("inverse"), 0) for case in cases), 1e-12)[0]


def members(scale: BenchScale) -> Iterator[PairedComparison]:
    """Ensembles: one member against many, each with a batch of its own."""
    batch = scale.many_batch
    for number in scale.many:
        one = Contender("1 member", fastest("inverse").step)
        case = partial(pendulum_case, network(t2, PAPER_HIDDEN), number, batch)
        many = Contender(f"{number} members", fastest("inverse").step, case)
        yield compared(scale, "members", PAPER_HIDDEN, one, many, MEMBERS, batch=batch)
