"""What the optimisers that look at all samples at once have in common: one member after another, in float64."""

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Self

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

    def shortened(self, share: float) -> Self:
        """The same for a share of the iterations."""
        return replace(self, iterations=math.ceil(share * self.iterations))

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
            solution = self.solve(member, parameters[number].double().numpy(), told)
            state["done"].append((*solution, member.margins))
            checkpoint.save(state)
        weights, losses, status, margins = zip(*state["done"], strict=True)
        fitted = torch.from_numpy(np.stack(weights))
        curves = merge_curves(losses, "loss") + merge_curves(margins, "passivity_margin")
        return Fitted(fitted, curves, list(status), {"epochs": self.iterations})


def merge_curves(curves: tuple[list[float], ...], name: str) -> Curve:
    """Curves of different lengths as one, each held at its last value: [(step, name, (member,))]; none of none."""
    steps = max(len(curve) for curve in curves)
    if not steps:
        return []
    padded = np.array([curve + [curve[-1]] * (steps - len(curve)) for curve in curves])
    return [(step, name, padded[:, step]) for step in range(steps)]


def _share(progress: Progress, number: int, members: int) -> Progress:
    return lambda fraction, text: progress((number + fraction) / members, text)
