"""Simulated data from keywords that are checked as settings are; each input has its own limit unless one is given."""

from collections.abc import Sequence
from typing import Any

from repro.data import free_motion as without_force
from repro.data import random_force as under_force
from repro.data.data_options import FreeMotionOptions, RandomForce
from repro.data.dataset import Dataset
from repro.mechanics.system import System
from repro.plugins.checked import validated


def random_force(system: System, *, seeds: Sequence[int], **options: Any) -> Dataset:
    return under_force.random_force(system, seeds, validated(RandomForce, "data", {"force_limit": None, **options}))


def free_motion(system: System, *, seeds: Sequence[int], train_fraction: float = 0.8, **options: Any) -> Dataset:
    return without_force.free_motion(system, seeds, validated(FreeMotionOptions, "data", options), train_fraction)
