"""Fits an ensemble to its data, and stores the weights and the learning curves."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from repro.codegen.lazy_torch import torch
from repro.learning.phases import TrainingData
from repro.learning.result import Curve, Fitted
from repro.library.ensemble import fit_ensemble
from repro.pipeline.stage_options import FitOptions
from repro.pipeline.stages.stored_fit import (
    CURVES,
    PARAMETERS,
    forced_data,
    free_data,
    load_parameters,
    model_of,
    system_of,
)
from repro.tracking import progress
from repro.tracking.files import replacing
from repro.tracking.plain_data import Json
from repro.tracking.record import Record

KEPT = "kept_weights.npz"  # at points of the learning curves
PAUSE_SECONDS = 10.0  # between two checkpoints
FAR = 0.2  # of the cost per degree of freedom from 1, that is worth a notice


def make(folder: Path, options: FitOptions, upstream: Mapping[str, Record]) -> Json:
    """Fit the ensemble; an interrupted attempt is resumed.

    upstream: parts and data, and `pretraining`, the first phase, where that is a stage of its own.
    """
    model = model_of(options, upstream)
    data = training_data(options, upstream)
    before = upstream.get("pretraining")
    beginning = before is None and options.training is not None and options.training.sequence.beginning is not None
    fitted, seconds = fit_ensemble(
        model,
        options.training,
        data,
        lambda fraction, text: progress.report(0.05 + (0.4 if beginning else 0.85) * fraction, text),
        FileCheckpoint(folder),
        None if before is None else stored(before),
        beginning,
    )
    seconds += 0.0 if before is None else before.summary["seconds"]
    if reason := fitted.notes.get("not_captured"):
        progress.notice(f"without CUDA graphs, so more slowly: {reason}")
    for cost in fitted.notes.get("cost_per_dof", []):
        if abs(cost - 1) > FAR and options.training and options.training.objective.expects_unit_cost:
            progress.notice(
                f"cost per degree of freedom {cost:.3g}, 1 is expected: the model, the noise levels or the "
                "sub-steps do not suit the recording, or the fit has not converged"
            )
            break
    return keep(folder, fitted, options.seeds, seconds) | {"n_parameters": model.n_parameters}


def training_data(options: FitOptions, upstream: Mapping[str, Record]) -> TrainingData:
    """What the ensemble is trained on, from the stages upstream of its fit."""
    return TrainingData(forced_data(upstream), free_data(upstream), system_of(options), options.seeds)


def keep(folder: Path, fitted: Fitted, seeds: Sequence[int], seconds: float) -> Json:
    """Write the weights and the learning curves; return the summary."""
    arrays = {"parameters": np.asarray(fitted.parameters, dtype=float), "seeds": np.array(seeds)}
    if fitted.information is not None:
        arrays["information"] = fitted.information
    np.savez(folder / PARAMETERS, **arrays)  # type: ignore[arg-type]
    if kept := {f"{step} {name}": weights for step, name, weights in fitted.curves if weights.ndim > 1}:
        np.savez(folder / KEPT, **kept)  # type: ignore[arg-type]
    rows = [
        (seed, step, name, float(value))
        for step, name, values in fitted.curves
        if values.ndim == 1
        for seed, value in zip(seeds, values, strict=True)
    ]
    table = pd.DataFrame(rows, columns=["member", "step", "name", "value"])
    table = table.astype({"member": "int64", "step": "int64", "name": "object", "value": "float64"})
    table.to_parquet(folder / CURVES, index=False)
    return {"status": fitted.status, "seconds": seconds, "notes": fitted.notes}


def stored(stage: Record) -> Fitted:
    """What `keep` wrote."""
    summary, table, folder = stage.summary, stage.table("curves"), stage.folder
    parameters = load_parameters(folder)
    values = table["value"].to_numpy().reshape(-1, len(parameters))
    first = table.iloc[:: len(parameters)]
    curves: Curve = list(zip(first["step"].tolist(), first["name"].tolist(), values, strict=True))
    if (path := stage.path(KEPT)).is_file():
        with np.load(path) as kept:
            named = ((*key.split(" ", 1), weights) for key, weights in kept.items())
            curves += [(int(step), name, weights) for step, name, weights in named]
    return Fitted(parameters, curves, summary["status"], summary["notes"])


class FileCheckpoint:
    """Keeps a fit's state in `folder`, so that it resumes after a kill or Ctrl-C."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "checkpoint.pt"
        self.last = time.monotonic()

    def load(self) -> object | None:
        """The last whole state, or None."""
        if not self.path.exists():
            return None
        state: object = torch.load(self.path, weights_only=False)
        return state

    def save(self, state: object) -> None:
        """Write the state if the last time is long enough ago."""
        if time.monotonic() - self.last < PAUSE_SECONDS:
            return
        with replacing(self.path) as temporary, temporary.open("wb") as file:
            torch.save(state, file)
        self.last = time.monotonic()
