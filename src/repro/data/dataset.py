"""The one container of data: arrays with shapes and units, a training part and a test part."""

import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import active_engine
from repro.mechanics.system import System

ARRAYS = "data.npz"
DESCRIPTION = "data.json"
EXACT = 1e-6  # m, rad, m/s, rad/s: standard deviation that stands for a sensor without noise


@dataclass(frozen=True)
class Measurement:
    """Recorded positions, and velocities where there are any: (member, sample, n_q), NaN where a sample is missing.

    q_noise, qd_noise, tau_noise: standard deviations (n_q,) of the sensors, None where they are not known.
    """

    q: np.ndarray
    qd: np.ndarray | None = None
    q_noise: np.ndarray | None = None
    qd_noise: np.ndarray | None = None
    tau_noise: np.ndarray | None = None

    def changed(self, change: Callable[[np.ndarray], np.ndarray]) -> "Measurement":
        """The same with both recorded arrays changed."""
        return replace(self, q=change(self.q), qd=None if self.qd is None else change(self.qd))

    def arrays(self) -> dict[str, np.ndarray]:
        """Everything that is there, by name, as it is stored."""
        named = {f"measured.{field.name}": getattr(self, field.name) for field in fields(self)}
        return {name: array for name, array in named.items() if array is not None}

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> "Measurement | None":
        """Taken out of stored arrays, None where no sensor is described."""
        own = {name.partition(".")[2]: arrays.pop(name) for name in [*arrays] if name.startswith("measured.")}
        return cls(**own) if own else None


@dataclass(frozen=True)
class Dataset:
    """Samples of independent members; sample k is the state at the start of step k and the tau held over it.

    q, qd, qdd, tau: (member, sample, n_q); time: (sample,) s, running on from episode to episode; episode: (sample,);
    energy: (member, sample) J where it is known, else None. The first n_train samples are for training. measurement:
    what sensors recorded, where q, qd, qdd are estimates that were made from it.
    """

    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    tau: np.ndarray
    time: np.ndarray
    episode: np.ndarray
    n_train: int
    coordinates: tuple[Coordinate, ...]
    time_step: float
    energy: np.ndarray | None = None
    measurement: Measurement | None = None
    provenance: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        members, samples, _ = self.q.shape
        vectors = (members, samples, len(self.coordinates))
        expected: dict[str, tuple[int, ...]] = dict.fromkeys(("q", "qd", "qdd", "tau"), vectors)
        expected |= {"time": (samples,), "episode": (samples,)}
        if self.energy is not None:
            expected["energy"] = (members, samples)
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} should have shape {shape}, not {getattr(self, name).shape}")
        if not 0 <= self.n_train <= samples:
            raise ValueError(f"n_train = {self.n_train} is not within the {samples} samples")

    @classmethod
    def from_motion(
        cls,
        system: System,
        states: np.ndarray,
        tau: np.ndarray,
        *,
        time_step: float,
        episode_steps: int,
        n_train: int,
        provenance: Mapping[str, object],
        energy: np.ndarray | None = None,
    ) -> "Dataset":
        """Simulated states (member, sample, 2 n_q) = [q, qd] under tau (member, sample, n_q), with exact qdd.

        A new episode starts every `episode_steps` samples; energy: (member, sample) in J.
        """
        samples = states.shape[1]
        q, qd = states[..., : system.n_q].copy(), states[..., system.n_q :].copy()
        return cls(
            q=q,
            qd=qd,
            qdd=evaluate(dynamics_of(system).acceleration, q, qd, tau),
            tau=tau,
            time=np.arange(samples) * time_step,
            episode=np.arange(samples) // episode_steps,
            n_train=n_train,
            coordinates=system.coordinates,
            time_step=time_step,
            energy=energy,
            provenance={"system": system.describe(), "engine": active_engine(), **provenance},
        )

    @property
    def members(self) -> int:
        """Number of independent members."""
        return int(self.q.shape[0])

    @property
    def samples(self) -> int:
        """Number of samples per member."""
        return int(self.q.shape[1])

    @property
    def angles(self) -> tuple[int, ...]:
        """Positions of the angles among the coordinates."""
        return tuple(i for i, coordinate in enumerate(self.coordinates) if coordinate.is_angle)

    @property
    def n_q(self) -> int:
        """Number of generalised coordinates."""
        return int(self.q.shape[2])

    @property
    def train(self) -> "Dataset":
        """The first n_train samples."""
        return self.select(slice(None, self.n_train), self.n_train)

    @property
    def test(self) -> "Dataset":
        """The samples after the first n_train."""
        return self.select(slice(self.n_train, None), 0)

    def save(self, folder: Path) -> None:
        """Write data.npz (arrays) and data.json (what they mean, their units, what made them) into a folder."""
        arrays = {name: getattr(self, name) for name in ("q", "qd", "qdd", "tau", "time", "episode")}
        if self.energy is not None:
            arrays["energy"] = self.energy
        if self.measurement is not None:
            arrays |= self.measurement.arrays()
        folder.mkdir(parents=True, exist_ok=True)
        np.savez(folder / ARRAYS, **arrays)
        description = {
            "coordinates": [asdict(coordinate) for coordinate in self.coordinates],
            "units": units(self.coordinates),
            "shapes": {name: list(array.shape) for name, array in arrays.items()},
            "n_train": self.n_train,
            "time_step": self.time_step,
            "provenance": dict(self.provenance),
        }
        (folder / DESCRIPTION).write_text(json.dumps(description, indent=2) + "\n")

    @classmethod
    def load(cls, folder: Path) -> "Dataset":
        """Read what `save` wrote; UserError naming the file that is missing, damaged or does not fit the other."""
        path = folder / DESCRIPTION
        try:
            description = json.loads(path.read_text())
            path = folder / ARRAYS
            with path.open("rb") as file, np.load(file) as stored:
                arrays = {name: stored[name] for name in stored.files}
            return cls(
                measurement=Measurement.of(arrays),
                coordinates=tuple(Coordinate(**coordinate) for coordinate in description["coordinates"]),
                **{name: description[name] for name in ("n_train", "time_step", "provenance")},
                **arrays,
            )
        except FileNotFoundError as error:
            raise UserError(f"{path} is missing: make the data again") from error
        except (OSError, EOFError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
            raise UserError(f"{path} is damaged ({error}): delete its folder and make the data again") from error

    def select(self, samples: slice | np.ndarray, n_train: int) -> "Dataset":
        """These samples of every member, the first n_train of them for training."""
        common = {"time": self.time[samples], "episode": self.episode[samples], "n_train": n_train}
        return self._changed(lambda each: each[:, samples], **common)

    def of_members(self, chosen: Sequence[int]) -> "Dataset":
        """The samples of these members, in this order; one that is named several times is repeated."""
        return self._changed(lambda each: each[list(chosen)])

    def _changed(self, change: Callable[[np.ndarray], np.ndarray], **common: Any) -> "Dataset":
        """With all arrays (member, ...) changed, and others given."""
        own: dict[str, Any] = {name: getattr(self, name) for name in ("q", "qd", "qdd", "tau", "energy")}
        own = {name: None if array is None else change(array) for name, array in own.items()}
        return replace(self, **own, measurement=self.measurement and self.measurement.changed(change), **common)


def units(coordinates: tuple[Coordinate, ...]) -> dict[str, str | list[str]]:
    """Units of every array, one list entry per coordinate."""
    names = [coordinate.unit for coordinate in coordinates]
    return {
        "q": names,
        "qd": [f"{unit}/s" for unit in names],
        "qdd": [f"{unit}/s^2" for unit in names],
        "tau": [coordinate.force_unit for coordinate in coordinates],
        "time": "s",
        "energy": "J",
    }


def check_seeds(seeds: Sequence[int]) -> None:
    """UserError unless there is at least one seed, none negative, none twice."""
    if not len(seeds) or min(seeds) < 0 or len(set(seeds)) != len(seeds):
        raise UserError(f"seeds = {list(seeds)}: give at least one, none negative, none twice")


def training_size(samples: int, train_fraction: float, what: str = "samples") -> int:
    """Return how many of the samples are for training; UserError where that leaves none for training or for test."""
    n_train = round(samples * train_fraction) if 0 < train_fraction < 1 else 0
    if not 0 < n_train < samples:
        raise UserError(
            f"train_fraction = {train_fraction} of {samples} {what} leaves no training or no test data: "
            f"choose it between 0 and 1, and enough {what}"
        )
    return n_train
