"""The phases of a training: which losses on which data, in which order."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import assert_never

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.codegen.lazy_torch import torch
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.learning.balance import balance_task
from repro.learning.objective import Objective
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.sequence_options import SequenceKind, SequenceOptions
from repro.learning.training import Phase, make_task
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.learning.watch import InertiaWatch, PassivityWatch, Watch
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.damped import without_damping
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.passivity_margin import States


@dataclass(frozen=True)
class TrainingData:
    """What a model is trained on: the datasets of the curriculum, then D; D_H and the system, or None."""

    forced: Sequence[Dataset]
    free: Dataset | None
    system: System | None
    seeds: Sequence[int]


def phases_of(model: Model, objective: ObjectiveOptions, sequence: SequenceOptions, data: TrainingData) -> list[Phase]:
    """What is minimised, in turn. Raises ValueError where D_H is needed and missing."""
    equation = Objective(objective.kind, objective.momentum_weight)
    energetic = replace(equation, energy_weight=sequence.energy_weight, energy_form=sequence.energy_form)
    l1, watches = _l1(model, objective), _watches(model, objective.passivity_states, data)

    def problem(*tasks: TrainingTask) -> TrainingProblem:
        return TrainingProblem(model, tasks, data.seeds, l1, watches)

    def task(dataset: Dataset, minimised: Objective) -> TrainingTask:
        if objective.kind.begins_with_balance:
            return balance_task(model, dataset.train, minimised, objective.window, objective.error_scale)
        return make_task(model, dataset.train, minimised, error_scale=objective.error_scale)

    def on_free_motion() -> TrainingTask:
        if data.free is None:
            raise ValueError(f"sequence {sequence.kind} needs D_H")
        return task(data.free, energetic)

    name, beside = "D", list[TrainingTask]()
    match sequence.kind:
        case SequenceKind.JOINT:
            name, beside = "D and D_H", [on_free_motion()]
        case SequenceKind.ANCHORED:
            beside = [_anchor_task(model, data, energetic)]
        case SequenceKind.MAIN | SequenceKind.PRETRAIN | SequenceKind.PRETRAIN_ONLY:
            pass
        case _:
            assert_never(sequence.kind)

    phases = []
    if sequence.kind.begins_with_free_motion:
        phases.append(Phase("D_H", problem(on_free_motion()), sequence.pretraining_epochs))
    if sequence.kind is not SequenceKind.PRETRAIN_ONLY:
        last = len(data.forced)
        for number, dataset in enumerate(data.forced, start=1):
            label = name if number == last else f"{name}, stage {number}"
            phases.append(Phase(label, problem(task(dataset, equation), *beside)))
    if objective.equal_weight_share:
        equal = [replace(one, sample_weight=None) for one in phases[-1].problem.tasks]
        phases.append(Phase("equal weights", problem(*equal), share=objective.equal_weight_share))
    return phases


def _anchor_task(model: Model, data: TrainingData, objective: Objective) -> TrainingTask:
    """The energy of one state, the upright rest, as in III-A.1 after Greydanus et al. (2019)."""
    if (system := data.system) is None:
        raise UserError("sequence anchored: the true system is needed, whose energy at the upright rest is the anchor")
    shape = (len(data.seeds), 1, system.n_q)
    q, zero = np.broadcast_to(system.at_rest(), shape).copy(), np.zeros(shape)
    energy = evaluate(dynamics_of(system).hamiltonian, q, zero)[..., 0]
    state = Dataset(
        q=q, qd=zero, qdd=zero, tau=zero, time=np.zeros(1), episode=np.zeros(1, dtype=int), n_train=1,
        coordinates=system.coordinates, time_step=1.0, energy=energy,
    )  # fmt: skip
    return make_task(model, state, replace(objective, equation=None, momentum_weight=0.0))


def _watches(model: Model, count: int, data: TrainingData) -> list[Watch]:
    watches: list[Watch] = []
    final = data.forced[-1]
    if model.energetic:
        watches.append(InertiaWatch.over(model, final.test))
    if count:
        velocities = final.train.qd.reshape(-1, final.n_q).std(axis=0)
        states = States.random(final.coordinates, velocities, count, np.random.default_rng([count, 5]))
        watches.append(PassivityWatch(model, states, None if model.energetic else data.system))
    return watches


def _l1(model: Model, objective: ObjectiveOptions) -> "torch.Tensor | None":
    learned = without_damping(model)
    if not isinstance(learned, Lagrangian) or not (objective.l1_kinetic or objective.l1_potential):
        return None
    weights = torch.zeros(model.n_parameters, dtype=torch.float64)
    weights[learned.kinetic_slice] = objective.l1_kinetic
    weights[learned.potential_slice] = objective.l1_potential
    return weights
