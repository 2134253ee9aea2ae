"""What the optimisers that look at all samples at once have in common: one member after another, in float64."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from repro.codegen.lazy_torch import torch
from repro.learning.kernels.kernel import Evaluations
from repro.learning.members import MemberProblem
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.result import Checkpoint, Curve, Fitted, Notes, Progress, Weights, part
from repro.learning.training_problem import TrainingProblem
from repro.plugins.options import Count, Natural, Positive

Solution = tuple[np.ndarray, list[float], str]  # weights (n_parameters,), loss after each iteration, status
USUAL_MEMBERS = 5  # what is worth compiling must not depend on their number: rounding would then, too
_Done = tuple[np.ndarray, list[float], str, dict[str, dict[int, np.ndarray]]]  # a solution and its watched values


@dataclass(frozen=True)
class FullBatch(OptimiserOptions):
    """At most `iterations` on the same `samples` random training samples of each member; None: on all.

    budget_s: CPU seconds per member, looked at after every iteration.
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = "iterations"

    iterations: Natural = 100
    samples: Count | None = None
    budget_s: Positive | None = None

    def solve(self, problem: MemberProblem, start: np.ndarray, progress: Progress) -> Solution:
        """Fit one member from the weights `start` (n_parameters,); `problem.look` at a step's weights is followed."""
        raise NotImplementedError

    def fit(self, problem: TrainingProblem, parameters: Weights, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Train from `parameters` (member, n_parameters); the result is float64."""
        reduced = problem.subsample(self.samples)
        evaluations = Evaluations(USUAL_MEMBERS * self.evaluations, sum(task.samples for task in reduced.tasks))
        state = checkpoint.load()
        done: list[_Done] = list(state) if isinstance(state, list) else []
        for number in range(len(done), problem.members):
            deadline = math.inf if self.budget_s is None else time.process_time() + self.budget_s
            member = MemberProblem(reduced.member(number), evaluations, deadline)
            own = part(progress, number, problem.members)
            solution = self.solve(member, np.asarray(parameters[number], dtype=float), own)
            done.append((*solution, member.watched))
            checkpoint.save(done)
        weights, losses, status, watched = zip(*done, strict=True)
        fitted = torch.from_numpy(np.stack(weights))
        curves = merge_curves([dict(enumerate(each)) for each in losses], "loss")
        for watch in problem.watches:
            curves += merge_curves([each.get(watch.name, {}) for each in watched], watch.name)
        return Fitted(fitted, curves, list(status), Notes(epochs=self.iterations))


def merge_curves(curves: Sequence[Mapping[int, float | np.ndarray]], name: str) -> Curve:
    """The members' curves, step -> value, as one; each is held at its last value: [(step, name, (member, ...))].

    nan where a member has none yet.
    """
    latest: np.ndarray | list[float] = [math.nan] * len(curves)
    merged = []
    for step in sorted(set().union(*curves)):
        latest = np.array([curve.get(step, before) for curve, before in zip(curves, latest, strict=True)])
        merged.append((step, name, latest))
    return merged
