"""How much is timed at each scale."""

from collections.abc import Sequence
from dataclasses import dataclass

from repro.bench.pairing import Rounds

Hidden = tuple[int, ...]

PAPER_HIDDEN: Hidden = (10,)  # of the paper's inverse model
OPTIMISERS = ("Adam", "L-BFGS", "Levenberg-Marquardt")


@dataclass(frozen=True)
class RaceSize:
    """A race to accuracies."""

    starts: int  # random starts, each with samples of its own: `samples` to train on, a quarter of that to be judged on
    samples: int
    optimisers: Sequence[str]  # of the paper's model; the last is the fastest
    goals: Sequence[float]  # errors, as shares of those of a model without motion or energy
    limit_s: float  # seconds that a training has at most
    patience: float  # times the seconds of the path fit that a neural ODE has


@dataclass(frozen=True)
class BenchScale:
    """How much is timed."""

    rounds: Rounds
    sizes: Sequence[Hidden]  # hidden layers that are compared
    ensemble: int  # members of an ensemble
    race: RaceSize
    coordinates: Sequence[int]  # values of n_q whose cost is divided by that of the first
    streamed: Sequence[int]  # numbers of samples of the least squares beyond memory
    many: Sequence[int]  # numbers of members side by side, with `many_batch` samples each
    control_steps: int  # of a swing-up
    batch: int = 2048
    compile_torch: bool = False  # compare with torch.compile, which takes tens of seconds to start
    large: Sequence[Hidden] = ()  # networks that take minutes on a full batch: compared with rivals on `large_batch`
    large_batch: int = 256
    many_batch: int = 256


SCALES = {
    "smoke": BenchScale(
        Rounds(least=2, most=2, limit_s=0.0),
        batch=256,
        sizes=[PAPER_HIDDEN],
        ensemble=2,
        race=RaceSize(1, 500, OPTIMISERS[-1:], goals=[0.5], limit_s=0.1, patience=1.0),
        coordinates=[2, 3],
        streamed=[1_000],
        many=[2],
        control_steps=2,
    ),
    "quick": BenchScale(
        Rounds(least=5, most=15, limit_s=0.7),
        sizes=[PAPER_HIDDEN, (64, 64)],
        ensemble=10,
        race=RaceSize(2, 6144, OPTIMISERS, goals=[0.3, 0.1], limit_s=1.0, patience=5.0),
        coordinates=[2, 4, 8],
        streamed=[1_000, 100_000],
        many=[10],
        control_steps=20,
    ),
    "paper": BenchScale(
        Rounds(least=7, most=31, limit_s=1.5),
        sizes=[PAPER_HIDDEN, (16, 16), (32, 32), (64, 64)],
        ensemble=10,
        race=RaceSize(5, 6144, OPTIMISERS, goals=[0.3, 0.1, 0.01, 0.001], limit_s=8.0, patience=10.0),
        coordinates=[2, 1, 3, 4, 5, 6, 7, 8],
        streamed=[1_000, 10_000, 100_000, 1_000_000, 10_000_000],
        many=[10, 100, 1_000],
        control_steps=60,
        compile_torch=True,
        large=[(500, 500)],
    ),
}
