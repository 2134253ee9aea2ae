"""Fit an ensemble to its data, in the phases that the sequence and the curriculum ask for."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from repro.codegen.array_evaluation import evaluate
from repro.data.dataset import Dataset
from repro.learning.objective import Equation, Objective
from repro.learning.optimiser import Optimiser
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.result import Checkpoint, Fitted, Progress
from repro.learning.training import Phase, make_task, train
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.learning.watch import InertiaWatch, PassivityWatch, Watch
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.context import Context, SubModel
from repro.models.damped import without_damping
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.options import ModelOptions
from repro.models.passivity_margin import States
from repro.plugins.plugin import plugin

PARAMETERS, CURVES = "parameters.npz", "curves.parquet"


@dataclass(frozen=True)
class Recipe:
    """What to minimise on which data; see conf/objective and conf/sequence for the options."""

    objective: Mapping[str, Any]
    sequence: Mapping[str, Any]
    seeds: Sequence[int]


def build_model(
    options: ModelOptions,
    basis: str,
    data: Sequence[Dataset],
    system: System | None,
    parts: Sequence[SubModel] = (),
) -> Model:
    """The model that its file of models/kinds builds; data: the curriculum's datasets, then D itself."""
    final = data[-1].train
    context = Context(
        plugin("models.bases", basis), final.coordinates, final.q, final.qd, data[0].train.qd, system, tuple(parts)
    )
    return plugin("models.kinds", options.kind).build(context, options)


def build_optimiser(options: OptimiserOptions, device: str = "cpu") -> Optimiser:
    """The optimiser that its file of learning/optimisers builds, on a device."""
    optimiser = plugin("learning.optimisers", options.kind).build(options)
    if device == "cpu":
        return optimiser
    return plugin("learning.device", "device_adam").DeviceAdam.of(optimiser, device)


def fit(
    model: Model,
    recipe: Recipe,
    optimiser: Optimiser,
    data: Sequence[Dataset],
    free: Dataset | None,
    system: System,
    progress: Progress,
    checkpoint: Checkpoint,
) -> tuple[Fitted, float]:
    """Fit and return the result with the CPU seconds it took; data: the curriculum's datasets, then D itself."""
    generators = [np.random.default_rng([seed, 1]) for seed in recipe.seeds]
    parameters = torch.from_numpy(model.initial(generators))
    if model.fixed == slice(0, model.n_parameters):
        return Fitted(parameters, status=["ok"] * len(parameters), notes={"epochs": 0}), 0.0
    phases = phases_of(model, recipe, data, free, system)
    started = time.process_time()
    fitted = train(phases, optimiser, parameters, progress, checkpoint)
    return fitted, time.process_time() - started


def keep(folder: Path, fitted: Fitted, seeds: Sequence[int], seconds: float) -> dict[str, Any]:
    """Write the weights and the learning curves; return the summary."""
    import pandas as pd

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


def load_parameters(folder: Path) -> torch.Tensor:
    """The fitted weights (member, n_parameters)."""
    with np.load(folder / PARAMETERS) as stored:
        return torch.from_numpy(stored["parameters"])


def phases_of(
    model: Model, recipe: Recipe, data: Sequence[Dataset], free: Dataset | None, system: System
) -> list[Phase]:
    """What is minimised, in turn; data: the curriculum's datasets, then D itself; free: D_H, where asked for."""
    chosen, sequence = recipe.objective, recipe.sequence
    objective = Objective(Equation(chosen["kind"]), chosen["momentum_weight"])
    energetic = replace(objective, energy_weight=sequence["energy_weight"], energy_form=sequence["energy_form"])
    l1, watches = _l1(model, chosen), _watches(model, chosen.get("passivity_states", 0), data[-1], system)

    def task(dataset: Dataset | None, wanted: Objective) -> TrainingTask:
        if dataset is None:
            raise ValueError(f"sequence {sequence['kind']} needs D_H")
        return make_task(model, dataset.train, wanted, error_scale=chosen["error_scale"])

    def problem(*tasks: TrainingTask) -> TrainingProblem:
        return TrainingProblem(model, tasks, recipe.seeds, l1, watches)

    kind = sequence["kind"]
    phases = []
    if kind in ("pretrain_only", "pretrain"):
        phases.append(Phase("D_H", problem(task(free, energetic)), sequence.get("pretraining_epochs")))
    for number, dataset in enumerate(data if kind != "pretrain_only" else ()):
        tasks = [task(dataset, objective)]
        if kind == "joint":
            tasks.append(task(free, energetic))
        if kind == "anchored":
            tasks.append(_anchor_task(model, system, recipe.seeds, energetic))
        name = "D and D_H" if kind == "joint" else "D"
        name += "" if number == len(data) - 1 else f", stage {number + 1}"
        phases.append(Phase(name, problem(*tasks)))
    if chosen["equal_weight_share"]:
        equal = [replace(one, sample_weight=None) for one in phases[-1].problem.tasks]
        phases.append(Phase("equal weights", problem(*equal), share=chosen["equal_weight_share"]))
    return phases


def _anchor_task(model: Model, system: System, seeds: Sequence[int], objective: Objective) -> TrainingTask:
    """The energy of one state, the upright rest, as in III-A.1 after Greydanus et al. (2019)."""
    shape = (len(seeds), 1, system.n_q)
    q, zero = np.broadcast_to(system.upright, shape).copy(), np.zeros(shape)
    energy = evaluate(dynamics_of(system).hamiltonian, q, zero)[..., 0]
    state = Dataset(
        q=q, qd=zero, qdd=zero, tau=zero, time=np.zeros(1), episode=np.zeros(1, dtype=int), n_train=1,
        coordinates=system.coordinates, time_step=1.0, energy=energy,
    )  # fmt: skip
    return make_task(model, state, replace(objective, equation=None, momentum_weight=0.0))


def _watches(model: Model, count: int, data: Dataset, system: System) -> list[Watch]:
    watches: list[Watch] = []
    if model.energetic:
        watches.append(InertiaWatch.over(model, data.test))
    if count:
        velocities = data.train.qd.reshape(-1, data.n_q).std(axis=0)
        states = States.random(data.coordinates, velocities, count, np.random.default_rng([count, 5]))
        watches.append(PassivityWatch(model, states, None if model.energetic else system))
    return watches


def _l1(model: Model, objective: Mapping[str, Any]) -> torch.Tensor | None:
    learned = without_damping(model)
    if not isinstance(learned, Lagrangian) or not (objective["l1_kinetic"] or objective["l1_potential"]):
        return None
    weights = torch.zeros(model.n_parameters, dtype=torch.float64)
    weights[learned.kinetic_slice] = objective["l1_kinetic"]
    weights[learned.potential_slice] = objective["l1_potential"]
    return weights
