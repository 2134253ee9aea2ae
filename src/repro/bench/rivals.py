"""The rivals of claim C11, each compared naive with naive, best with best, and by the time to equal accuracy."""

from collections.abc import Iterator
from functools import partial
from itertools import product

from repro.bench.accuracy import METRICS, RESOLUTION, Race, racer
from repro.bench.contender import Contender, by_hessian, compared, fastest, in_torch, size_text
from repro.bench.naive import (
    automatic_problem,
    automatic_step,
    engineered_features,
    naive_problem,
    naive_step,
    t2_features,
)
from repro.bench.pairing import PairedComparison
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import (
    EPISODE_STEPS,
    TrainingCase,
    network,
    pendulum,
    pendulum_case,
    triangular,
    wide,
)
from repro.models.bases import engineered, t2

RIVALS = {"lnn": "LNN (Cranmer et al. 2020)", "delan": "DeLaN (Lutter et al. 2019)", "linn": "LINN (Bao et al. 2021)"}
PROTOCOLS = {
    "lnn_naive": "; the same network, weights, samples and way of computing",
    "lnn_best": "; the same network, weights and samples; the derivatives of the features prepared for both",
    "delan_naive": "; DeLaN: a triangular factor of M from a network of cos and sin, in torch, by the chain rule",
    "delan_automatic": "; DeLaN: the same factor, the derivatives of M and V by jacfwd for every sample",
    "delan_best": "; DeLaN: the same factor, both in our engine",
    "linn_naive": "; LINN has no public code, so taken as one network of [q; qd; cos q; sin q], vmap(hessian), inverse "
    "loss",
    "linn_best": "; LINN: one network of [q; qd; cos q; sin q], both in our engine",
}


def steps_of_rivals(scale: BenchScale) -> Iterator[PairedComparison]:
    """One training step of the inverse model against that of each rival: all naive, then all in this engine."""
    lnn, delan, linn = RIVALS.values()
    for hidden in [*scale.sizes, *scale.large]:
        batch = scale.large_batch if hidden in scale.large else scale.batch
        factor = partial(pendulum_case, triangular(hidden), 1, batch)
        one_network = partial(pendulum_case, network(engineered, hidden), 1, batch)
        linn_step = partial(naive_step, equation="inverse", features=engineered_features)
        naive, best = by_hessian("inverse"), fastest("inverse")
        pairs = {
            "lnn_naive": (naive, Contender(lnn, by_hessian("forward").step)),
            "lnn_best": (best, Contender(lnn, fastest("forward").step)),
            "delan_naive": (naive, Contender(delan, in_torch("inverse").step, factor)),
            "delan_automatic": (naive, Contender(delan, automatic_step, factor)),
            "delan_best": (best, Contender(delan, best.step, factor)),
            "linn_naive": (naive, Contender(linn, linn_step, one_network)),
            "linn_best": (best, Contender(linn, best.step, one_network)),
        }
        for name, pair in pairs.items():
            yield compared(scale, name, hidden, *pair, PROTOCOLS[name], batch=batch)


def time_to_accuracy(scale: BenchScale) -> Iterator[PairedComparison]:
    """Training from random starts to several errors on held-out samples.

    The paper's model against each rival, both under one optimiser and in one way of computing; then its optimisers, and
    this project's own model against the paper's and against DeLaN.
    """
    size, best = scale.race, scale.race.optimisers[-1]
    held_out = size.samples // 4
    race = Race(partial(pendulum, range(size.starts), size.samples + held_out), size.goals, size.limit_s)
    protocol = (
        f"processor time of training from a random start until {{metric}} on {held_out} held-out samples is {{goal:g}} "
        "of that of a model without motion or energy (of H after one constant), known to a factor of "
        f"{RESOLUTION:g}; one thread, {size.samples} samples in episodes of {EPISODE_STEPS} steps; {{{{pairs}}}} "
        f"starts, one per pair; infinite: not reached in the {size.limit_s:g} s that each training has"
    )
    inverse, forward = (partial(TrainingCase.problem, equation=each) for each in ("inverse", "forward"))
    by_hessians = partial(naive_problem, equation="inverse", features=t2_features)
    paper, factor = network(t2, PAPER_HIDDEN), triangular(PAPER_HIDDEN)
    lnn, delan, linn = RIVALS.values()
    plnn = partial(racer, "PLNN, inverse", paper, inverse)
    compiled = racer(delan, factor, inverse, best)
    analytic = racer(f"{delan}, analytic", factor, inverse, "Adam, torch")
    automatic = racer(f"{delan}, automatic", factor, automatic_problem, "Adam, torch")
    naive = racer("PLNN, inverse, vmap(hessian)", paper, by_hessians, "Adam, torch")
    own = racer("structured", wide(PAPER_HIDDEN), inverse, best)
    contests = [
        *(("lnn_accuracy", plnn(each), racer(lnn, paper, forward, each)) for each in size.optimisers),
        ("delan_accuracy", plnn(best), compiled),
        ("delan_analytic_accuracy", plnn("Adam, torch"), analytic),
        ("delan_automatic_accuracy", naive, automatic),
        ("linn_accuracy", plnn(best), racer(linn, network(engineered, PAPER_HIDDEN), inverse, best)),
        *(("optimisers", plnn(best), plnn(each)) for each in size.optimisers[:-1]),
        *(("structured_accuracy", own, other) for other in (plnn("Adam"), plnn(best), compiled, analytic, automatic)),
    ]
    for (name, ours, other), metric, goal in product(contests, METRICS, size.goals):
        measure, text = partial(race.pairs, ours, other, metric, goal), protocol.format(metric=metric, goal=goal)
        labels = ours.label, other.label, size_text(PAPER_HIDDEN)
        yield PairedComparison(name, *labels, 1, text, measure, metric, goal)
