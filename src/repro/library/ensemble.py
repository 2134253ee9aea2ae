"""One ensemble fitted: its model built for the data, its optimiser, and the weights of all members."""

import time
from collections.abc import Sequence

import numpy as np

from repro.data.dataset import Dataset
from repro.learning.phases import TrainingData, phases_of
from repro.learning.result import Checkpoint, Fitted, Progress, silent
from repro.learning.training import train
from repro.learning.training_options import Training
from repro.mechanics.system import System
from repro.models.context import Context, SubModel
from repro.models.model import Model
from repro.models.model_options import ModelOptions
from repro.plugins.plugin import plugin


def build_model(
    options: ModelOptions, basis: str, data: Sequence[Dataset], system: System | None, parts: Sequence[SubModel] = ()
) -> Model:
    """The model that its file of models/kinds builds; data: the curriculum's datasets, then D itself."""
    final = data[-1].train
    features, first = plugin("models.bases", basis), data[0].train
    context = Context(features, final.coordinates, final.q, final.qd, first.qd, system, tuple(parts))
    model: Model = plugin("models.kinds", options.kind).build(context, options)
    return model


def fit_ensemble(
    model: Model,
    training: Training | None,
    data: TrainingData,
    progress: Progress = silent,
    checkpoint: Checkpoint | None = None,
    begun: Fitted | None = None,
    beginning: bool = False,
) -> tuple[Fitted, float]:
    """Fit and return the result with the CPU seconds it took; without weights to fit the start is the result.

    beginning: solve the first phase alone; begun: its result, where that was done before.
    """
    generators = [np.random.default_rng([seed, 1]) for seed in data.seeds]
    parameters = model.initial(generators)
    if training is None or model.fixed == slice(0, model.n_parameters):
        return Fitted(parameters, status=["ok"] * len(parameters), notes={"epochs": 0}), 0.0
    phases = phases_of(model, training.objective, training.sequence, data)
    started = time.process_time()
    optimiser = training.optimiser
    if training.device != "cpu":
        optimiser = plugin("learning.device", "device_adam").DeviceAdam.of(optimiser, training.device)
    fitted = train(phases[:1] if beginning else phases, optimiser, parameters, progress, checkpoint, begun)
    if not beginning:
        fitted = training.objective.finished(model, data.forced[-1].train, fitted, parameters, progress)
    return fitted, time.process_time() - started
