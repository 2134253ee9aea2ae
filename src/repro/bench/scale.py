"""How much is timed at each scale."""

from collections.abc import Sequence
from dataclasses import dataclass

from repro.bench.accuracy import OPTIMISERS
from repro.bench.pairing import Rounds

Hidden = tuple[int, ...]

PAPERS: Hidden = (10,)  # of the paper's inverse model; small enough for generated code


@dataclass(frozen=True)
class RaceSize:
    """A race to a training MAE_tau of `threshold`; see `Race` for patience and limit_s."""

    optimisers: Sequence[str]
    members: int
    samples: int
    threshold: float
    patience: float
    limit_s: float


@dataclass(frozen=True)
class Scale:
    """Rounds of every comparison of steps, the hidden layers that are compared, the members of an ensemble, the race.

    large: networks that would take minutes on a full batch, and are timed on `large_batch` samples.
    """

    rounds: Rounds
    sizes: Sequence[Hidden]
    ensemble: int
    race: RaceSize
    batch: int = 2048
    large: Sequence[Hidden] = ()
    large_batch: int = 256


SCALES = {
    "smoke": Scale(
        Rounds(least=2, most=2, limit_s=0.0),
        batch=256,
        sizes=[PAPERS],
        ensemble=2,
        race=RaceSize(["Levenberg-Marquardt"], members=1, samples=500, threshold=0.5, patience=1.0, limit_s=0.2),
    ),
    "quick": Scale(
        Rounds(least=5, most=15, limit_s=0.7),
        sizes=[PAPERS, (64, 64)],
        ensemble=10,
        race=RaceSize(list(OPTIMISERS), members=2, samples=6144, threshold=0.1, patience=1.0, limit_s=3.0),
    ),
    "paper": Scale(
        Rounds(least=7, most=31, limit_s=4.0),
        sizes=[PAPERS, (32, 32), (64, 64)],
        ensemble=10,
        race=RaceSize(list(OPTIMISERS), members=5, samples=6144, threshold=0.1, patience=3.0, limit_s=10.0),
        large=[(500, 500)],
    ),
}
