"""Fits an ensemble to its data, and stores the weights and the learning curves."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import torch

from repro.learning.optimiser import Optimiser
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.result import Checkpoint, Fitted, Progress
from repro.learning.training import train
from repro.mechanics.system import load_system
from repro.models.model import Model
from repro.pipeline.stage_options import FitOptions, Training
from repro.pipeline.stages.checkpoint import FileCheckpoint
from repro.pipeline.stages.phases import TrainingData, phases_of
from repro.pipeline.stages.stored_fit import CURVES, PARAMETERS, forced_data, free_data, model_of
from repro.plugins.plugin import plugin
from repro.tracking import progress
from repro.tracking.load import Run
from repro.tracking.plain_data import Json


def make(folder: Path, options: FitOptions, upstream: Mapping[str, Run]) -> Json:
    """Fit the ensemble; an interrupted attempt is resumed."""
    model = model_of(options, upstream)
    data = training_data(options, upstream)
    fitted, seconds = fit(
        model,
        options.training,
        data,
        lambda fraction, text: progress.report(0.05 + 0.85 * fraction, text),
        FileCheckpoint(folder),
    )
    if reason := fitted.notes.get("not_captured"):
        progress.notice(f"without CUDA graphs, so more slowly: {reason}")
    return keep(folder, fitted, options.seeds, seconds) | {"n_parameters": model.n_parameters}


def training_data(options: FitOptions, upstream: Mapping[str, Run]) -> TrainingData:
    """What the ensemble is trained on, from the stages upstream of its fit."""
    return TrainingData(forced_data(upstream), free_data(upstream), load_system(options.system), options.seeds)


def fit(
    model: Model, training: Training | None, data: TrainingData, progress: Progress, checkpoint: Checkpoint
) -> tuple[Fitted, float]:
    """Fit and return the result with the CPU seconds it took; without weights to fit the start is the result."""
    generators = [np.random.default_rng([seed, 1]) for seed in data.seeds]
    parameters = torch.from_numpy(model.initial(generators))
    if training is None or model.fixed == slice(0, model.n_parameters):
        return Fitted(parameters, status=["ok"] * len(parameters), notes={"epochs": 0}), 0.0
    phases = phases_of(model, training.objective, training.sequence, data)
    started = time.process_time()
    optimiser = build_optimiser(training.optimiser, training.device)
    fitted = train(phases, optimiser, parameters, progress, checkpoint)
    return fitted, time.process_time() - started


def build_optimiser(options: OptimiserOptions, device: str = "cpu") -> Optimiser:
    """The optimiser that its file of learning/optimisers builds, on a device."""
    optimiser: Optimiser = plugin("learning.optimisers", options.kind).build(options)
    if device != "cpu":
        optimiser = plugin("learning.device", "device_adam").DeviceAdam.of(optimiser, device)
    return optimiser


def keep(folder: Path, fitted: Fitted, seeds: Sequence[int], seconds: float) -> Json:
    """Write the weights and the learning curves; return the summary."""
    np.savez(folder / PARAMETERS, parameters=fitted.parameters.double().numpy(), seeds=np.array(seeds))
    rows = [
        (seed, step, name, float(value))
        for step, name, values in fitted.curves
        for seed, value in zip(seeds, values, strict=True)
    ]
    table = pd.DataFrame(rows, columns=["member", "step", "name", "value"])
    table = table.astype({"member": "int64", "step": "int64", "name": "object", "value": "float64"})
    table.to_parquet(folder / CURVES, index=False)
    return {"status": fitted.status, "seconds": seconds, "notes": fitted.notes}
