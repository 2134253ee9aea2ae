"""What the training data of a linear model can tell: examined member by member, and written beside the metrics."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from repro.data.dataset import Dataset
from repro.evaluation.identifiability import Identifiability, identifiability
from repro.evaluation.pointwise import MetricValues
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.optimisers.least_squares import regression
from repro.learning.phases import TrainingData, phases_of
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training import Phase
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model

FILE = "identifiability.parquet"
SAMPLES = 10_000  # of D and of D_H: enough for a rank, and for a condition number to two digits


def identified(
    model: Model, objective: ObjectiveOptions, sequence: SequenceOptions, data: TrainingData
) -> dict[str, list[Identifiability]]:
    """What the data show of a linear model, one entry per seed, by the phase of its training; empty for others."""
    if not applies(model, objective):
        return {}
    free = None if data.free is None else shortened(data.free)
    few = replace(data, forced=[shortened(each) for each in data.forced], free=free)
    return examine(model, phases_of(model, objective, sequence, few))


def applies(model: Model, objective: ObjectiveOptions) -> bool:
    """Whether a fit is a linear regression: a basis, and the inverse equation or the momentum balance."""
    return isinstance(model, Lagrangian) and model.linear and objective.linear


def shortened(dataset: Dataset) -> Dataset:
    """The dataset with no more training samples than an examination needs."""
    return replace(dataset, n_train=min(dataset.n_train, SAMPLES))


def examine(model: Model, phases: Sequence[Phase]) -> dict[str, list[Identifiability]]:
    """What the data of each phase show of a linear model, one entry per seed, by the name of the phase."""
    assert isinstance(model, Lagrangian)
    n_kinetic = len(model.kinetic_features)
    return {
        phase.name: [
            identifiability(regression(phase.problem, member)[0], model.coefficient_names, n_kinetic)
            for member in range(phase.problem.members)
        ]
        for phase in phases
    }


def metrics(members: Sequence[Identifiability]) -> Iterator[MetricValues]:
    """Rank, number of null directions and condition numbers, one value per seed."""
    for name, values in {
        "rank": [one.rank for one in members],
        "null_directions": [len(one.null_directions) for one in members],
        "condition_raw": [one.condition_raw for one in members],
        "condition_scaled": [one.condition_scaled for one in members],
    }.items():
        yield MetricValues("train", name, np.array(values, dtype=float), "1")


def keep(folder: Path, phases: dict[str, list[Identifiability]], seeds: Sequence[int]) -> None:
    """Write one row per phase, seed and direction: singular value, and a description where it is not identifiable."""
    rows = [
        (seed, phase, order, float(value), one.words[order - one.rank] if order >= one.rank else "")
        for phase, members in phases.items()
        for seed, one in zip(seeds, members, strict=True)
        for order, value in enumerate(one.singular_values)
    ]
    table = pd.DataFrame(rows, columns=["member", "phase", "order", "value", "direction"])
    table.to_parquet(folder / FILE, index=False)
