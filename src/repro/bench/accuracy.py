"""Seconds of training until the model is good enough, by optimiser and objective."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from torch import Tensor

from repro.bench.case import Case, Equation
from repro.bench.pairing import Clock, Pairs
from repro.learning.adam import Adam
from repro.learning.lbfgs import LBFGS
from repro.learning.levenberg_marquardt import LevenbergMarquardt
from repro.learning.optimiser import Optimiser
from repro.learning.problem import Problem
from repro.learning.result import NoCheckpoint, silent

GROWTH = 1.5  # from one budget to the next: a time is known to this factor
OPTIMISERS: Mapping[str, tuple[Callable[[int], Optimiser], int]] = {  # by number of iterations, and the first to try
    "Adam": (lambda epochs: Adam(epochs=epochs), 40),
    "L-BFGS": (lambda iterations: LBFGS(iterations=iterations), 20),
    "Levenberg-Marquardt": (lambda iterations: LevenbergMarquardt(iterations=iterations), 10),
}


@dataclass(frozen=True)
class Race:
    """From one random start a member to a training MAE_tau of `threshold`, every optimiser with its usual settings.

    Budgets grow until one reaches the threshold or takes longer than `limit_s`; the forward objective is given up
    after `patience` times the seconds of the inverse one.
    """

    build_case: Callable[[], Case]
    threshold: float
    patience: float
    limit_s: float
    clock: Clock = time.process_time

    def forward_against_inverse(self, optimiser: str) -> Pairs:
        """Inverse (ours) and forward with the same optimiser, a pair a member."""
        inverse = self._inverse(optimiser)
        limits = [self.patience * s if math.isfinite(s) else self.limit_s for s in inverse]
        return Pairs(inverse, np.array([self._seconds(optimiser, "forward", m, s) for m, s in enumerate(limits)]))

    def optimisers(self, ours: str, other: str) -> Pairs:
        """Two optimisers of the inverse objective, a pair a member."""
        return Pairs(self._inverse(ours), self._inverse(other))

    @cached_property
    def case(self) -> Case:
        """The networks and their samples."""
        return self.build_case()

    @cached_property
    def _members(self) -> Mapping[Equation, Sequence[Problem]]:
        equations: tuple[Equation, ...] = ("inverse", "forward")
        problems = {equation: self.case.problem(equation) for equation in equations}
        return {name: [whole.member(m) for m in range(self.case.members)] for name, whole in problems.items()}

    @cached_property
    def _known(self) -> dict[str, np.ndarray]:
        return {}

    def _inverse(self, optimiser: str) -> np.ndarray:
        if optimiser not in self._known:
            seconds = [self._seconds(optimiser, "inverse", m, self.limit_s) for m in range(self.case.members)]
            self._known[optimiser] = np.array(seconds)
        return self._known[optimiser]

    def _seconds(self, optimiser: str, equation: Equation, member: int, limit_s: float) -> float:
        build, budget = OPTIMISERS[optimiser]
        problem, start = self._members[equation][member], self.case.parameters[member : member + 1]
        build(1).fit(problem, start, silent, NoCheckpoint())  # a warm-up: code is generated here
        while True:
            begun = self.clock()
            fitted = build(budget).fit(problem, start, silent, NoCheckpoint())
            seconds = self.clock() - begun
            if self.error(fitted.parameters, member) <= self.threshold:
                return seconds
            if seconds > limit_s:
                return math.inf
            budget = math.ceil(GROWTH * budget)

    def error(self, parameters: Tensor, member: int) -> float:
        """MAE_tau on a member's training samples, whatever it was trained for; parameters (1, n_parameters)."""
        (task,) = self._members["inverse"][member].tasks
        tau = self.case.model.evaluate(parameters.double(), task.prepared).tau
        return math.inf if tau is None else (tau - task.measured["tau"]).abs().mean().item()
