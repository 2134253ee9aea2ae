"""The rivals of claim C11, each compared naive with naive, best with best, and by the time to equal accuracy."""

from collections.abc import Iterator
from functools import cache, partial

from repro.bench.accuracy import GROWTH, Race, Racer
from repro.bench.contender import STEP, Contender, by_hessian, compared, fastest, size_text, t2_case
from repro.bench.delan import delan_step
from repro.bench.naive import engineered_features, naive_step
from repro.bench.pairing import PairedComparison
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import lagrangian_case, triangular_case
from repro.models.bases import engineered, t2

FASTEST_OPTIMISER = "Levenberg-Marquardt"

RIVALS = {"lnn": "LNN (Cranmer et al. 2020)", "delan": "DeLaN (Lutter et al. 2019)", "linn": "LINN (Bao et al. 2021)"}
PROTOCOLS = {
    "lnn_naive": "; the same network, weights, samples and way of computing",
    "lnn_best": "; the same network, weights and samples; the derivatives of the features prepared for both",
    "delan_naive": "; DeLaN written anew from its paper in torch (softplus layers of q)",
    "delan_automatic": "; DeLaN written anew, the derivatives of M by jacfwd for every sample",
    "delan_best": "; DeLaN: a triangular factor of M from a network of cos and sin, both in our engine",
    "linn_naive": "; LINN has no public code, so taken as one network of [q; qd; cos q; sin q], vmap(hessian), inverse "
    "loss",
    "linn_best": "; LINN: one network of [q; qd; cos q; sin q], both in our engine",
}


def steps_of_rivals(scale: BenchScale) -> Iterator[PairedComparison]:
    """One training step of the inverse model against that of each rival: all naive, then all in this engine."""
    lnn, delan, linn = RIVALS.values()
    for hidden in [*scale.sizes, *scale.large]:
        batch = scale.large_batch if hidden in scale.large else scale.batch
        case, protocol = t2_case(hidden, 1, batch), STEP.format(batch=batch)
        triangular = partial(triangular_case, hidden, 1, batch)
        one_network = partial(lagrangian_case, engineered, hidden, 1, batch)
        linn_step = partial(naive_step, equation="inverse", features=engineered_features)
        naive, best = by_hessian("inverse"), fastest("inverse")
        pairs = {
            "lnn_naive": (naive, Contender(lnn, by_hessian("forward").step)),
            "lnn_best": (best, Contender(lnn, fastest("forward").step)),
            "delan_naive": (naive, Contender(delan, partial(delan_step, hidden=hidden))),
            "delan_automatic": (naive, Contender(delan, partial(delan_step, hidden=hidden, automatic=True))),
            "delan_best": (best, Contender(delan, best.step, triangular)),
            "linn_naive": (naive, Contender(linn, linn_step, one_network)),
            "linn_best": (best, Contender(linn, best.step, one_network)),
        }
        for name, pair in pairs.items():
            yield compared(scale, name, hidden, case, pair, protocol + PROTOCOLS[name])


def time_to_accuracy(scale: BenchScale) -> Iterator[PairedComparison]:
    """Training from a random start to one error of tau: each rival with the fastest optimiser, and every optimiser."""
    size = scale.race
    shape = (PAPER_HIDDEN, size.members, size.samples)
    models = {
        "PLNN": cache(partial(lagrangian_case, t2, *shape)),
        RIVALS["delan"]: cache(partial(triangular_case, *shape)),
        RIVALS["linn"]: cache(partial(lagrangian_case, engineered, *shape)),
    }
    race = Race(models, size)
    protocol = (
        f"processor time of training from a random start to a training MAE_tau of {size.threshold:g}; one thread, "
        f"{size.samples} samples in episodes of 100 steps; budgets grow by {GROWTH:g}; {{pairs}} starts, one per pair; "
        f"infinite: not reached in {size.patience:g} times the seconds of ours, or in {size.limit_s:g} s"
    )

    def one(name: str, ours: Racer, other: Racer) -> PairedComparison:
        measure = partial(race.pairs, ours, other)
        return PairedComparison(name, ours.label, other.label, size_text(PAPER_HIDDEN), 1, protocol, measure)

    for optimiser in size.optimisers:
        ours = Racer("PLNN", "inverse", optimiser)
        yield one("lnn_accuracy", ours, Racer("PLNN", "forward", optimiser))
    best = Racer("PLNN", "inverse", FASTEST_OPTIMISER)
    for rival in ("delan", "linn"):
        yield one(f"{rival}_accuracy", best, Racer(RIVALS[rival], "inverse", FASTEST_OPTIMISER))
    for optimiser in size.optimisers:
        if optimiser != FASTEST_OPTIMISER:
            yield one("optimisers", best, Racer("PLNN", "inverse", optimiser))
