"""Make a dataset and write it down."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from repro.data.dataset import Dataset
from repro.data.free_motion import free_motion
from repro.data.random_force import random_force
from repro.data.recording_file import from_file
from repro.mechanics.system import System, load

ROLES = ("q", "qd", "tau", "qdd", "time", "episode")


def true_system(options: Mapping[str, Any], reading: str) -> System:
    """The true system of a run; options: name, damping, damping_frame and constants."""
    return load(reading=reading, **options)


def make_forced(folder: Path, system: System, seeds: Sequence[int], options: Mapping[str, Any]) -> dict[str, Any]:
    """D: simulated under a random force; options as in `random_force`."""
    return _keep(folder, random_force(system, seeds=seeds, **options))


def make_free(folder: Path, system: System, seeds: Sequence[int], options: Mapping[str, Any]) -> dict[str, Any]:
    """D_H: simulated without force; options as in `free_motion`."""
    return _keep(folder, free_motion(system, seeds=seeds, **options))


def read_recording(folder: Path, system: System, seeds: Sequence[int], options: Mapping[str, Any]) -> dict[str, Any]:
    """One's own recording, in the coordinates of the system."""
    columns = {role: names for role, names in options["columns"].items() if names}
    dataset = from_file(
        options["path"],
        columns=columns,
        coordinates=system.coordinates,
        time_step=options["time_step"],
        train_fraction=options["train_fraction"],
        members=len(seeds),
    )
    return _keep(folder, dataset)


def _keep(folder: Path, dataset: Dataset) -> dict[str, Any]:
    dataset.save(folder)
    return {
        "members": dataset.members,
        "samples": dataset.samples,
        "n_train": dataset.n_train,
        "provenance": dict(dataset.provenance),
    }
