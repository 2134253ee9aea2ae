"""What the optimisers that look at all samples at once have in common: one member after another, in float64."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from repro.learning.members import MemberProblem
from repro.learning.optimiser import Optimiser
from repro.learning.problem import Problem
from repro.learning.result import Checkpoint, Curve, Fitted, Progress

Solution = tuple[np.ndarray, list[float], str]  # weights (n_parameters,), loss after each iteration, status


@dataclass(frozen=True)
class FullBatch(Optimiser):
    """At most `iterations` on the same `samples` random training samples of each member."""

    iterations: int = 100
    samples: int | None = None

    @abstractmethod
    def solve(self, problem: MemberProblem, start: np.ndarray, progress: Progress) -> Solution:
        """Fit one member from the weights `start` (n_parameters,)."""

    def fit(self, problem: Problem, parameters: Tensor, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Train from `parameters` (member, n_parameters); the result is float64."""
        reduced = problem.subsample(self.samples)
        state = checkpoint.load() or {"done": []}
        for number in range(len(state["done"]), problem.members):
            member = MemberProblem(reduced.member(number))
            told = _share(progress, number, problem.members)
            state["done"].append(self.solve(member, parameters[number].double().numpy(), told))
            checkpoint.save(state)
        weights, curves, status = zip(*state["done"], strict=True)
        fitted = torch.from_numpy(np.stack(weights))
        return Fitted(fitted, merge_curves(curves), list(status), {"epochs": self.iterations})


def merge_curves(curves: tuple[list[float], ...]) -> Curve:
    """Curves of different lengths as one, each held at its last value: [(step, "loss", (member,))]."""
    steps = max(len(curve) for curve in curves)
    padded = np.array([curve + [curve[-1]] * (steps - len(curve)) for curve in curves])
    return [(step, "loss", padded[:, step]) for step in range(steps)]


def _share(progress: Progress, number: int, members: int) -> Progress:
    return lambda fraction, text: progress((number + fraction) / members, text)
