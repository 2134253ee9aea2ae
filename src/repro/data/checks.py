"""Checks of arguments, shared by everything that makes data."""

from collections.abc import Sequence

from repro.errors import UserError


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
