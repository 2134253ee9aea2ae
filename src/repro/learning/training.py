"""A fit in phases: each starts where the last one ended (curricula, pretraining and fine-tuning)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from repro.data.dataset import Dataset
from repro.learning.objective import Objective
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.result import Checkpoint, Fitted, NoCheckpoint, Progress, Weights, continued_curves, part, silent
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.learning.watch import watched
from repro.models.model import Model


@dataclass(frozen=True)
class Phase:
    """One problem to solve, with a name for the learning curves.

    epochs: where they are not the optimiser's own; share: of the epochs or iterations that the optimiser is to take.
    """

    name: str
    problem: TrainingProblem
    epochs: int | None = None
    share: float = 1.0

    def settings(self, optimiser: OptimiserOptions) -> OptimiserOptions:
        """The optimiser with this phase's epochs, where it counts in epochs, or its share of them."""
        return optimiser.shortened(self.share) if self.epochs is None else optimiser.lasting(self.epochs)


def train(
    phases: Sequence[Phase],
    optimiser: OptimiserOptions,
    parameters: Weights,
    progress: Progress = silent,
    checkpoint: Checkpoint | None = None,
    begun: Fitted | None = None,
) -> Fitted:
    """Solve the phases in turn. A member that diverges is put back to its last finite weights and keeps its status.

    begun: what `train` has made of the first phase alone, where that was solved before.
    """
    checkpoint = checkpoint or NoCheckpoint()
    state = checkpoint.load()
    if not isinstance(state, _State):
        state = _State(0, Fitted(parameters, status=["ok"] * len(parameters)))
        if begun is not None:
            state = _State(1, replace(begun, curves=watched(begun.curves, phases[0].problem.watches)))
    for number in range(state.phase, len(phases)):
        phase, before = phases[number], state.fitted
        chosen = phase.settings(optimiser.continued() if number else optimiser)
        own = part(progress, number, len(phases), f"{phase.name}: " if len(phases) > 1 else "")
        fitted = chosen.fit(phase.problem, before.parameters, own, _Inner(checkpoint, state))
        state = _State(number + 1, _chain(before, fitted, phase))
        checkpoint.save(state)
    return state.fitted


def make_task(model: Model, dataset: Dataset, objective: Objective, error_scale: float | None = None) -> TrainingTask:
    """A model's objective on the samples of a dataset.

    error_scale s (m/s^2 and rad/s^2 together) weighs each sample by 1 / (1 + |qdd|^2 / s^2): where the motion is
    violent a small relative error of M is a large error of tau.
    """
    measured = {"q": dataset.q, "qd": dataset.qd, "qdd": dataset.qdd, "tau": dataset.tau}
    if dataset.energy is not None:
        measured["energy"] = dataset.energy
    weight = None
    if error_scale is not None:
        weight = 1 / (1 + (dataset.qdd**2).sum(-1) / error_scale**2)
    return TrainingTask(model, objective, measured, weight)


@dataclass(frozen=True)
class _State:
    """What the phases before `phase` have fitted, and the optimiser's own state within it."""

    phase: int
    fitted: Fitted
    inner: object = None


class _Inner:
    """The optimiser's own state, kept inside the training's checkpoint."""

    def __init__(self, outer: Checkpoint, state: _State) -> None:
        self.outer, self.state = outer, state

    def load(self) -> object:
        return self.state.inner

    def save(self, state: object) -> None:
        self.outer.save(replace(self.state, inner=state))


def _chain(before: Fitted, after: Fitted, phase: Phase) -> Fitted:
    status = [
        old if old != "ok" else new if new == "ok" else f"{new} of {phase.name}"
        for old, new in zip(before.status, after.status, strict=True)
    ]
    notes = before.notes | after.notes
    if phase.share < 1:  # an ending of the phase before, not a training of its own
        notes["epochs"] = before.notes["epochs"] + after.notes["epochs"]
    return replace(after, curves=continued_curves(before.curves, after.curves), status=status, notes=notes)
