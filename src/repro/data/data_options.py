"""Options of the sources of data."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Literal

from annotated_types import Ge

from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate
from repro.plugins.options import Count, NotNegative, Options, Positive, Share

Samples = Annotated[int, Ge(10)]


@dataclass(frozen=True)
class RandomForce(Options):
    """Options of D, simulated under held random inputs: what each is stands in conf/data/episodes.yaml."""

    source: Literal["random_force"] = "random_force"
    regime: Literal["episodes", "long"] = "episodes"
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

    @property
    def noise(self) -> dict[str, float]:
        """Standard deviations by name."""
        return {name: getattr(self, f"{name}_noise") for name in ("tau", "qdd", "q", "qd", "force")}

    @property
    def held_samples(self) -> int:
        """Samples over which a force is held, at least 1."""
        return max(1, round(self.time_step / (self.sample_step or self.time_step)))

    def problems(self) -> Iterator[str]:
        """Options that do not fit each other, one line each."""
        if self.measured != "accelerations" and self.labels == "exact":
            yield (
                f"data.labels = 'exact': data.measured={self.measured} has no accelerations; use data.labels=smoothed"
            )
        if len(self.quantisation) not in (0, 2):
            steps = list(self.quantisation)
            yield f"data.quantisation = {steps}: two steps, of lengths (m) and of angles (rad), or none"
        ratio = self.time_step / (self.sample_step or self.time_step)
        if ratio < 1 or abs(ratio - round(ratio)) > 1e-6:
            yield (
                f"data.sample_step = {self.sample_step}: data.time_step = {self.time_step} s is no whole multiple of it"
            )


@dataclass(frozen=True)
class FreeMotionOptions(Options):
    """Options of D_H, motion without force from rest.

    grid, initial_angles  so many values of each coordinate in all combinations (`product`), or with all links at the
                          same angle (`diagonal`)
    steps, time_step      samples of each trajectory, and s between them
    """

    source: Literal["free_motion"] = "free_motion"
    initial_angles: Count = 100
    grid: Literal["product", "diagonal"] = "product"
    steps: Count = 10
    time_step: Positive = 0.04


@dataclass(frozen=True)
class Columns(Options):
    """Names of the columns of a recording that hold each role, in the order of the coordinates."""

    q: tuple[str, ...]
    qd: tuple[str, ...] = ()
    tau: tuple[str, ...] = ()
    qdd: tuple[str, ...] = ()
    time: tuple[str, ...] = ()
    episode: tuple[str, ...] = ()

    @property
    def named(self) -> dict[str, tuple[str, ...]]:
        """The roles that have columns."""
        return {field.name: names for field in fields(self) if (names := getattr(self, field.name))}


@dataclass(frozen=True)
class Units(Options):
    """Units of those columns, or factors to SI units; none where they are in SI units."""

    q: tuple[str | float, ...] = ()
    qd: tuple[str | float, ...] = ()
    tau: tuple[str | float, ...] = ()
    qdd: tuple[str | float, ...] = ()
    time: tuple[str | float, ...] = ()


@dataclass(frozen=True)
class OwnCoordinates(Options):
    """The coordinates of a recording of a mechanism that is no system here; no names: those of the system.

    angles: those of the names that are angles; units: of all, else rad for angles and m for the others; cyclic: those
    that no energy depends on; absolute: angles from the vertical of links that hang on the one before.
    """

    names: tuple[str, ...] = ()
    angles: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    cyclic: tuple[str, ...] = ()
    absolute: tuple[str, ...] = ()

    def described(self) -> tuple[Coordinate, ...]:
        """The coordinates; UserError for names and units that do not fit together."""
        for key in ("angles", "cyclic", "absolute"):
            if unknown := [name for name in getattr(self, key) if name not in self.names]:
                raise UserError(f"data.coordinates.{key} = {unknown}: choose from the names {list(self.names)}")
        if len(set(self.names)) < len(self.names):
            raise UserError(f"data.coordinates.names = {list(self.names)}: give each name once")
        if len(self.units) not in (0, len(self.names)):
            raise UserError(f"data.coordinates.units = {list(self.units)}: needs one per name, or none")
        units = self.units or tuple("rad" if name in self.angles else "m" for name in self.names)
        return tuple(
            Coordinate(name, unit, name in self.angles, name in self.cyclic, name in self.absolute)
            for name, unit in zip(self.names, units, strict=True)
        )


@dataclass(frozen=True)
class RecordingFile(Options):
    """Options of a recording of the user; see `repro.data.recording_file`."""

    source: Literal["file"]
    path: str | tuple[str, ...]
    columns: Columns
    time_step: Positive | None = None
    train_fraction: Share = 0.8
    units: Units = Units()
    coordinates: OwnCoordinates = OwnCoordinates()
    driven: tuple[str, ...] = ()
    test_path: str | tuple[str, ...] | None = None
    test_episodes: tuple[str | int, ...] = ()
    labels: Literal["recorded", "differenced", "savitzky_golay", "smoothed"] = "recorded"
    missing: Literal["refuse", "drop"] = "refuse"
    checks: Literal["refuse", "warn"] = "refuse"

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files and folders to read, in order."""
        return _paths(self.path)

    @property
    def test_paths(self) -> tuple[Path, ...]:
        """The files and folders that are for testing alone."""
        return _paths(self.test_path or ())

    def plain(self) -> dict[str, Any]:
        """All options but the paths: the data are known by the digest of the files."""
        return {key: value for key, value in super().plain().items() if key not in ("path", "test_path")}


def _paths(given: str | tuple[str, ...]) -> tuple[Path, ...]:
    return tuple(Path(each).expanduser() for each in ((given,) if isinstance(given, str) else given))


DataSource = RandomForce | RecordingFile  # what conf/data chooses from
