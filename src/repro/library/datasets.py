"""Datasets from Python: one's own arrays or data frame, or a simulated system."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset, training_size
from repro.data.differentiation import difference
from repro.data.random_force import random_force
from repro.errors import UserError
from repro.library.choices import system as system_of
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.system import System
from repro.plugins.checked import validated

if TYPE_CHECKING:
    import pandas as pd


def dataset(
    q: ArrayLike,
    qd: ArrayLike,
    tau: ArrayLike,
    *,
    time_step: float,
    qdd: ArrayLike | None = None,
    episode: ArrayLike | None = None,
    coordinates: Sequence[str | Coordinate] | None = None,
    angles: Iterable[str] = (),
    cyclic: Iterable[str] = (),
    train_fraction: float = 0.8,
) -> Dataset:
    """Measured samples as a dataset; the first part is for training, the rest for testing.

    Parameters
    ----------
    q, qd, tau, qdd
        Positions (m, rad), velocities, generalised forces (N, N m) and accelerations, each (sample, n_q), or
        (member, sample, n_q) for independent members. Without qdd, qd is differenced within episodes, which blurs it
        over each step.
    time_step
        Between two samples, s.
    episode
        (sample,) a label that changes where a new motion starts; one motion by default.
    coordinates
        Names, q0, q1, ... by default; angles are in rad, all others in m.
    angles, cyclic
        Names of the coordinates that are angles, and of those on which neither T nor V depends.
    train_fraction
        Share of the samples that are for training.

    Returns
    -------
    Dataset
        Arrays (member, sample, n_q); `train` and `test` are its parts.

    Raises
    ------
    UserError
        For shapes that do not fit, numbers that are not finite, and names that are no coordinate.

    Examples
    --------
    >>> import numpy as np, repro
    >>> t = np.arange(500)[:, None] * 0.01
    >>> data = repro.dataset(np.sin(t), np.cos(t), 0 * t, time_step=0.01, coordinates=["x"])
    >>> data.members, data.samples, data.n_train
    (1, 500, 400)
    """
    arrays = {"q": q, "qd": qd, "tau": tau} | ({} if qdd is None else {"qdd": qdd})
    numbers = {name: _members(name, values) for name, values in arrays.items()}
    shape = numbers["q"].shape
    for name, values in numbers.items():
        if values.shape != shape:
            raise UserError(f"{name} has shape {values.shape}, q has {shape}: they must be equal")
    labels = np.zeros(shape[1], dtype=np.int64) if episode is None else np.unique(episode, return_inverse=True)[1]
    if labels.shape != shape[1:2]:
        raise UserError(f"episode has shape {labels.shape}: one label per sample is needed, ({shape[1]},)")
    time = np.arange(shape[1]) * time_step
    if "qdd" not in numbers:
        numbers["qdd"] = difference(numbers["qd"], time, labels)
    return Dataset(
        q=numbers["q"], qd=numbers["qd"], qdd=numbers["qdd"], tau=numbers["tau"],
        time=time, episode=labels, n_train=training_size(shape[1], train_fraction),
        coordinates=_coordinates(coordinates, shape[2], set(angles), set(cyclic)), time_step=time_step,
        provenance={"source": "arrays"},
    )  # fmt: skip


def dataset_from_frame(
    frame: "pd.DataFrame", *, q: Sequence[str], qd: Sequence[str], tau: Sequence[str], qdd: Sequence[str] = (),
    episode: str | None = None, coordinates: Sequence[str | Coordinate] | None = None, **options: Any,
) -> Dataset:  # fmt: skip
    """The columns of a data frame as a dataset.

    Parameters
    ----------
    frame
        One row per sample.
    q, qd, tau, qdd
        Names of columns, one per coordinate each: positions (m, rad), velocities, generalised forces (N, N m) and,
        where they are measured, accelerations.
    episode
        Name of the column whose value changes where a new motion starts.
    coordinates
        Names; those of the columns of q by default.
    options
        As for `dataset`: time_step (s), angles, cyclic, train_fraction.

    Returns
    -------
    Dataset
        With one member.

    Raises
    ------
    UserError
        For a column that is not there, and as for `dataset`.

    Examples
    --------
    >>> import pandas as pd, repro
    >>> frame = pd.DataFrame({"x": [0.0, 0.1, 0.3], "v": [1.0, 1.5, 2.0], "F": [1.0, 1.0, 1.0]})
    >>> repro.dataset_from_frame(frame, q=["x"], qd=["v"], tau=["F"], time_step=0.1).q.shape
    (1, 3, 1)
    """
    named = {"q": list(q), "qd": list(qd), "tau": list(tau)} | ({"qdd": list(qdd)} if qdd else {})
    columns = [name for names in named.values() for name in names] + ([] if episode is None else [episode])
    if missing := [name for name in columns if name not in frame]:
        raise UserError(f"the frame has no column {missing[0]!r}; it has {', '.join(map(str, frame.columns))}")
    arrays: dict[str, Any] = {role: frame[names].to_numpy(dtype=float) for role, names in named.items()}
    labels = None if episode is None else frame[episode].to_numpy()
    return dataset(**arrays, episode=labels, coordinates=coordinates or list(q), **options)


def simulate(system: str | System, *, seeds: int | Sequence[int] = 1, **options: Any) -> Dataset:
    """A system driven by a random force, with exact labels unless options say otherwise: D of the paper.

    Parameters
    ----------
    system
        Its name, such as "dip", or what `repro.system` returns.
    seeds
        How many independent members, or the seed of each.
    options
        As in conf/data/episodes.yaml: samples, time_step (s), force_limit (N), reset, tau_noise, ...

    Returns
    -------
    Dataset
        Arrays (member, sample, n_q).

    Raises
    ------
    UserError
        For an option that does not exist or is out of range.

    Examples
    --------
    >>> import repro
    >>> repro.simulate("sip", samples=200, reset="random").q.shape
    (1, 200, 2)
    """
    plant = system_of(system) if isinstance(system, str) else system
    source = validated(RandomForce, "simulate", options)
    return random_force(plant, seed_list(seeds), source)


def seed_list(seeds: int | Sequence[int]) -> tuple[int, ...]:
    """So many seeds from 0, or these."""
    return tuple(range(seeds)) if isinstance(seeds, int) else tuple(int(seed) for seed in seeds)


def for_members(data: Dataset, members: int) -> Dataset:
    """The dataset with a copy for each member where it has one alone; UserError where it has another number."""
    if data.members == members:
        return data
    if data.members != 1:
        raise UserError(f"the data have {data.members} members and {members} seeds are given: one of both, or as many")
    return data.of_members([0] * members)


def _members(name: str, values: ArrayLike) -> np.ndarray:
    array = np.array(values, dtype=float)
    if array.ndim == 2:
        array = array[None]
    if array.ndim != 3:
        raise UserError(f"{name} has shape {np.shape(values)}: (sample, n_q) or (member, sample, n_q) is needed")
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        raise UserError(f"{name} has no finite number at sample {bad[0, 1]}, coordinate {bad[0, 2]}")
    return array


def _coordinates(
    names: Sequence[str | Coordinate] | None, n_q: int, angles: set[str], cyclic: set[str]
) -> tuple[Coordinate, ...]:
    chosen = list(names) if names is not None else [f"q{index}" for index in range(n_q)]
    if len(chosen) != n_q:
        raise UserError(f"coordinates names {len(chosen)}, q has {n_q}")
    known = {entry if isinstance(entry, str) else entry.name for entry in chosen}
    if unknown := sorted((angles | cyclic) - known):
        raise UserError(f"{unknown[0]!r} is no coordinate; there are {', '.join(sorted(known))}")
    return tuple(
        entry
        if isinstance(entry, Coordinate)
        else Coordinate(entry, "rad" if entry in angles else "m", entry in angles, entry in cyclic)
        for entry in chosen
    )
