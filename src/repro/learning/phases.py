"""The phases of a training: which losses on which data, in which order."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.codegen.lazy_torch import torch
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.learning.objective import Objective
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.sequence_options import SequenceOptions
from repro.learning.training import Phase, make_task
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.learning.watch import InertiaWatch, PassivityWatch, Watch, WeightsKept
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.damped import without_damping
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.passivity_margin import States


@dataclass(frozen=True)
class TrainingData:
    """What a model is trained on: the datasets of the curriculum, then D; D_H and the system, or None.

    Without any of the first, D_H alone is learned, and kept weights take the place of watches on D.
    """

    forced: Sequence[Dataset]
    free: Dataset | None
    system: System | None
    seeds: Sequence[int]


def phases_of(model: Model, objective: ObjectiveOptions, sequence: SequenceOptions, data: TrainingData) -> list[Phase]:
    """What is minimised, in turn. Raises ValueError where D_H is needed and missing."""
    make = PhaseMaker(model, objective, sequence, data)
    phases = list(sequence.phases(make))
    if objective.equal_weight_share:
        equal = [replace(one, sample_weight=None) for one in phases[-1].problem.tasks]
        phases.append(replace(make.phase("equal weights", *equal), share=objective.equal_weight_share))
    return phases


@dataclass(frozen=True)
class PhaseMaker:
    """What a sequence makes its phases of."""

    model: Model
    objective: ObjectiveOptions
    sequence: SequenceOptions
    data: TrainingData

    def phase(self, name: str, *tasks: TrainingTask, epochs: int | None = None) -> Phase:
        """The tasks minimised together; epochs: where they are not the optimiser's own."""
        return Phase(name, TrainingProblem(self.model, tasks, self.data.seeds, self._l1, self._watches), epochs)

    def curriculum(self, name: str, *beside: TrainingTask) -> Iterator[Phase]:
        """A phase on every dataset of the curriculum, D itself the last, with other tasks beside it."""
        last = len(self.data.forced)
        for number, dataset in enumerate(self.data.forced, start=1):
            task = self.objective.task(self.model, dataset.train, Objective(self.objective))
            yield self.phase(name if number == last else f"{name}, stage {number}", task, *beside)

    def free(self) -> TrainingTask:
        """The equation of motion and the known energy of D_H; ValueError where it is missing."""
        if self.data.free is None:
            raise ValueError(f"sequence {self.sequence.kind} needs D_H")
        return self.objective.task(self.model, self.data.free.train, self._with_energy(self.objective))

    def anchor(self) -> TrainingTask:
        """The energy of one state, the upright rest, as in III-A.1 after Greydanus et al. (2019)."""
        if (system := self.data.system) is None:
            raise UserError(
                f"sequence {self.sequence.kind}: the true system is needed, whose energy at the upright rest is the "
                "anchor"
            )
        shape = (len(self.data.seeds), 1, system.n_q)
        q, zero = np.broadcast_to(system.at_rest(), shape).copy(), np.zeros(shape)
        energy = evaluate(dynamics_of(system).hamiltonian, q, zero)[..., 0]
        state = Dataset(
            q=q, qd=zero, qdd=zero, tau=zero, time=np.zeros(1), episode=np.zeros(1, dtype=int), n_train=1,
            coordinates=system.coordinates, time_step=1.0, energy=energy,
        )  # fmt: skip
        return make_task(self.model, state, self._with_energy(None))

    def _with_energy(self, equation: ObjectiveOptions | None) -> Objective:
        return Objective(equation, self.sequence.energy_weight, self.sequence.energy_form)

    @cached_property
    def _watches(self) -> list[Watch]:
        watches: list[Watch] = []
        model, count = self.model, self.objective.passivity_states
        if not self.data.forced:
            kinds = (InertiaWatch,) * model.energetic + (PassivityWatch,) * bool(count)
            return [WeightsKept(kind.name, kind.always) for kind in kinds]
        final = self.data.forced[-1]
        if model.energetic:
            watches.append(InertiaWatch.over(model, final.test))
        if count:
            velocities = final.train.qd.reshape(-1, final.n_q).std(axis=0)
            states = States.random(final.coordinates, velocities, count, np.random.default_rng([count, 5]))
            watches.append(PassivityWatch(model, states, None if model.energetic else self.data.system))
        return watches

    @cached_property
    def _l1(self) -> "torch.Tensor | None":
        learned, objective = without_damping(self.model), self.objective
        if not isinstance(learned, Lagrangian) or not (objective.l1_kinetic or objective.l1_potential):
            return None
        weights = torch.zeros(self.model.n_parameters, dtype=torch.float64)
        weights[learned.kinetic_slice] = objective.l1_kinetic
        weights[learned.potential_slice] = objective.l1_potential
        return weights
