"""What a fit leaves in the store, read back: its datasets, its model and the learned weights."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from repro.data.dataset import Dataset
from repro.library.ensemble import build_model
from repro.library.ensemble_model import Ensemble
from repro.mechanics.system import System, load_system
from repro.models.context import SubModel
from repro.models.model import Model
from repro.pipeline.stage_options import FitOptions
from repro.tracking.record import Record

PARAMETERS, CURVES = "parameters.npz", "curves.parquet"
# Stored datasets never change, and several stages of a run read the same ones.
_loaded = lru_cache(maxsize=4)(Dataset.load)


def dataset(stage: Record) -> Dataset:
    """The dataset of a stage."""
    return _loaded(stage.folder)


def forced_data(upstream: Mapping[str, Record]) -> list[Dataset]:
    """The datasets of the curriculum, then D, from the stages upstream of a fit; none where D_H alone is learned."""
    return [dataset(upstream[role]) for role in (*_numbered(upstream, "stage"), "data") if role in upstream]


def free_data(upstream: Mapping[str, Record]) -> Dataset | None:
    """D_H, where it is learned."""
    return dataset(upstream["free"]) if "free" in upstream else None


def load_parameters(folder: Path) -> np.ndarray:
    """The fitted weights (member, n_parameters)."""
    with np.load(folder / PARAMETERS) as stored:
        return np.asarray(stored["parameters"])


def system_of(options: FitOptions) -> System | None:
    """The system of a fit; None for a recording that has coordinates of its own."""
    return None if options.system is None else load_system(options.system)


def simulated_system(options: FitOptions) -> System:
    """The system of a fit to simulated data."""
    system = system_of(options)
    assert system is not None
    return system


def model_of(options: FitOptions, upstream: Mapping[str, Record]) -> Model:
    """The model of a fit, built for the data upstream of it and around its trained parts."""
    roles = _numbered(upstream, "part")
    parts = [part_of(part, upstream[role], options.seeds) for part, role in zip(options.parts, roles, strict=True)]
    system = system_of(options) if options.simulated else None
    data = forced_data(upstream) or [dataset(upstream["free"])]
    return build_model(options.model, options.basis, data, system, parts)


def ensemble_of(options: FitOptions, fit: Record) -> Ensemble:
    """The ensemble of a fit, without its learning curves; its system is the one that its data were simulated with."""
    summary, upstream = fit.summary, fit.upstream
    with np.load(fit.path(PARAMETERS)) as stored:
        weights, information = stored["parameters"], stored.get("information")
    return Ensemble(
        model_of(options, upstream),
        weights,
        options.seeds,
        dataset(upstream["data"]),
        tuple(summary["status"]),
        summary["seconds"],
        system=system_of(options) if options.simulated else None,
        information_=information,
        notes_=summary["notes"],
    )


def part_of(options: FitOptions, fit: Record, seeds: Sequence[int]) -> SubModel:
    """A trained sub-model with the weights of the members of these seeds, all of which it has."""
    weights = load_parameters(fit.folder)
    chosen = [options.seeds.index(seed) for seed in seeds]
    return SubModel(model_of(options, fit.upstream), weights[chosen])


def _numbered(upstream: Mapping[str, Record], word: str) -> list[str]:
    roles = (role for role in upstream if role.startswith(f"{word}_"))
    return sorted(roles, key=lambda role: int(role.rpartition("_")[2]))
