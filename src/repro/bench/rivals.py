"""The rivals of claim C11, each compared naive with naive, best with best, and by the time to equal accuracy."""

from collections.abc import Iterator
from functools import partial

from repro.bench.accuracy import GROWTH, Race, Racer
from repro.bench.comparison import PairedComparison
from repro.bench.contender import STEP, Contender, by_hessian, compared, fastest, size_text, t2_case
from repro.bench.delan import delan_step
from repro.bench.naive import engineered_features, naive_step
from repro.bench.scale import PAPER_HIDDEN, BenchScale
from repro.bench.training_case import lagrangian_case, triangular_case
from repro.models.bases import engineered, t2

FASTEST_OPTIMISER = "Levenberg-Marquardt"

RIVALS = {"lnn": "LNN (Cranmer et al. 2020)", "delan": "DeLaN (Lutter et al. 2019)", "linn": "LINN (Bao et al. 2021)"}
NAIVE = {
    "lnn": "; the same network, weights, samples and way of computing",
    "delan": "; DeLaN written anew from its paper in torch (softplus layers of q)",
    "linn": "; LINN has no public code, so taken as one network of [q; qd; cos q; sin q], vmap(hessian), inverse loss",
}
BEST = {
    "lnn": "; the same network, weights and samples; the derivatives of the features prepared for both",
    "delan": "; DeLaN: a triangular factor of M from a network of cos and sin, both in our engine",
    "linn": "; LINN: one network of [q; qd; cos q; sin q], both in our engine",
}


def steps_of_rivals(scale: BenchScale) -> Iterator[PairedComparison]:
    """One training step of the inverse model against that of each rival: all naive, then all in this engine."""
    for hidden in [*scale.sizes, *scale.large]:
        batch = scale.large_batch if hidden in scale.large else scale.batch
        case, protocol = t2_case(hidden, 1, batch), STEP.format(batch=batch)
        naive = {
            "lnn": by_hessian("forward"),
            "delan": Contender("", partial(delan_step, hidden=hidden)),
            "linn": Contender(
                "",
                partial(naive_step, equation="inverse", features=engineered_features),
                partial(lagrangian_case, engineered, hidden, 1, batch),
            ),
        }
        best = {
            "lnn": fastest("forward"),
            "delan": Contender("", fastest("inverse").step, partial(triangular_case, hidden, 1, batch)),
            "linn": Contender("", fastest("inverse").step, partial(lagrangian_case, engineered, hidden, 1, batch)),
        }
        for rival, label in RIVALS.items():
            for way, others, ours, text in [
                ("naive", naive, by_hessian("inverse"), NAIVE),
                ("best", best, fastest("inverse"), BEST),
            ]:
                other = Contender(label, others[rival].step, others[rival].case)
                pair = ours, other
                yield compared(scale, f"{rival}_{way}", size_text(hidden), case, pair, protocol + text[rival])


def time_to_accuracy(scale: BenchScale) -> Iterator[PairedComparison]:
    """Training from a random start to one error of tau: each rival with the fastest optimiser, and every optimiser."""
    size = scale.race
    shape = (PAPER_HIDDEN, size.members, size.samples)
    models = {
        "PLNN": partial(lagrangian_case, t2, *shape),
        RIVALS["delan"]: partial(triangular_case, *shape),
        RIVALS["linn"]: partial(lagrangian_case, engineered, *shape),
    }
    race = Race(models, size.threshold, size.patience, size.limit_s)
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
