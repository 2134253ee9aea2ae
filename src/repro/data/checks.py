"""Checks of arguments, shared by everything that makes data."""

import math
from collections.abc import Sequence

from repro.errors import UserError


def check_positive(**values: float) -> None:
    """UserError naming the argument that is not a finite number above 0."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0):
            raise UserError(f"{name} = {value}: it must be greater than 0")


def check_not_negative(**values: float) -> None:
    """UserError naming the argument that is not a finite number of at least 0."""
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0):
            raise UserError(f"{name} = {value}: it must be 0 or greater")


def check_choice(name: str, value: str, allowed: Sequence[str]) -> None:
    """UserError naming the argument and its allowed values."""
    if value not in allowed:
        raise UserError(f"{name} = {value!r}: choose one of {', '.join(allowed)}")


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
