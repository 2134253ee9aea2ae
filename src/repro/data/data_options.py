"""Options of the sources of data."""

from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Annotated, Any, Literal, assert_never

from annotated_types import Ge

from repro.plugins.options import Count, NotNegative, Options, Positive, Share

Samples = Annotated[int, Ge(10)]


class Regime(StrEnum):
    """How D is collected: in episodes of so many steps, or as one long trajectory."""

    EPISODES = "episodes"
    LONG = "long"

    def length(self, samples: int, episode_steps: int) -> int:
        """Samples from one start to the next."""
        match self:
            case Regime.EPISODES:
                return min(episode_steps, samples)
            case Regime.LONG:
                return samples
            case _:
                assert_never(self)


@dataclass(frozen=True)
class RandomForce(Options):
    """Options of D, simulated under a random force; see `repro.data.random_force`."""

    source: Literal["random_force"] = "random_force"
    regime: Regime = Regime.EPISODES
    episode_steps: Count = 1000
    samples: Samples = 100_000
    train_fraction: Share = 0.8
    train_samples: Count | None = None
    time_step: Positive = 0.04
    force_limit: Positive | None = 5.0
    start: str | None = None
    reset: Literal["start", "random"] = "start"
    measured: Literal["accelerations", "states", "positions"] = "accelerations"
    sample_step: Positive | None = None
    labels: Literal["exact", "differenced", "savitzky_golay", "smoothed"] = "exact"
    tau_noise: NotNegative = 0.0
    qdd_noise: NotNegative = 0.0
    q_noise: NotNegative = 0.0
    qd_noise: NotNegative = 0.0
    force_noise: NotNegative = 0.0
    quantisation: tuple[NotNegative, ...] = ()
    encoder_zero: float = 0.0
    wrapped: bool = False
    common: bool = False


@dataclass(frozen=True)
class FreeMotionOptions(Options):
    """Options of D_H, motion without force; see `repro.data.free_motion`."""

    source: Literal["free_motion"] = "free_motion"
    initial_angles: Count = 100
    grid: Literal["product", "diagonal"] = "product"
    steps: Count = 10
    time_step: Positive = 0.04


@dataclass(frozen=True)
class Columns(Options):
    """Names of the columns of a recording that hold each role, in the order of the coordinates."""

    q: tuple[str, ...]
    qd: tuple[str, ...]
    tau: tuple[str, ...]
    qdd: tuple[str, ...] = ()
    time: tuple[str, ...] = ()
    episode: tuple[str, ...] = ()

    @property
    def named(self) -> dict[str, tuple[str, ...]]:
        """The roles that have columns."""
        return {field.name: names for field in fields(self) if (names := getattr(self, field.name))}


@dataclass(frozen=True)
class RecordingFile(Options):
    """Options of a recording of the user; see `repro.data.recording_file`."""

    source: Literal["file"]
    path: str
    columns: Columns
    time_step: Positive | None
    train_fraction: Share


DataSource = RandomForce | RecordingFile  # what conf/data chooses from


def arguments(options: RandomForce | FreeMotionOptions) -> dict[str, Any]:
    """The options as keywords of the function that makes the data."""
    return {field.name: getattr(options, field.name) for field in fields(options) if field.name != "source"}
