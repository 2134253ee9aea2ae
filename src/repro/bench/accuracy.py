"""Seconds of training until the model is good enough: by model, equation and optimiser."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from torch import Tensor

from repro.bench.pairing import Clock, Pairs
from repro.bench.training_case import Equation, TrainingCase
from repro.learning.adam import Adam
from repro.learning.lbfgs import LBFGS
from repro.learning.levenberg_marquardt import LevenbergMarquardt
from repro.learning.optimiser import Optimiser
from repro.learning.result import NoCheckpoint, silent

GROWTH = 1.5  # from one budget to the next: a time is known to this factor
CONTINUED = ("Adam",)  # a longer training starts with the steps of the shorter one: its checkpoint is continued
OPTIMISERS: Mapping[str, tuple[Callable[[int], Optimiser], int]] = {  # by number of iterations, and the first to try
    "Adam": (lambda epochs: Adam(epochs=epochs), 40),
    "L-BFGS": (lambda iterations: LBFGS(iterations=iterations), 20),
    "Levenberg-Marquardt": (lambda iterations: LevenbergMarquardt(restarts=1, iterations=iterations), 10),
}


class MemoryCheckpoint:
    """A checkpoint that is kept in memory, see `repro.learning.result.Checkpoint`."""

    def __init__(self) -> None:
        self.state: object | None = None

    def load(self) -> object | None:
        """The last state, or None."""
        return self.state

    def save(self, state: object) -> None:
        """Replace the last state."""
        self.state = state


@dataclass(frozen=True)
class Racer:
    """A model by its name in the race, its training equation and its optimiser."""

    model: str
    equation: Equation
    optimiser: str

    @property
    def label(self) -> str:
        """A label for the tables."""
        return f"{self.model}, {self.equation}, {self.optimiser}"


@dataclass(frozen=True)
class RaceSize:
    """A race to a training MAE_tau of `threshold`.

    Budgets grow until one reaches the threshold, or takes longer than `limit_s` or than `patience` times the seconds of
    the racer it is compared with.
    """

    optimisers: Sequence[str]
    members: int
    samples: int
    threshold: float
    patience: float
    limit_s: float


@dataclass(frozen=True)
class Race:
    """Seconds from one random start per member to the threshold, optimisers at their defaults."""

    models: Mapping[str, Callable[[], TrainingCase]]
    size: RaceSize
    clock: Clock = time.process_time
    _known: dict[Racer, np.ndarray] = field(default_factory=dict)

    def pairs(self, ours: Racer, other: Racer) -> Pairs:
        """Both racers from the same seeds, one pair per member."""
        if ours not in self._known:
            members = range(self.models[ours.model]().members)
            self._known[ours] = np.array([self._seconds(ours, member, self.size.limit_s) for member in members])
        first = self._known[ours]
        limits = np.minimum(self.size.patience * first, self.size.limit_s)
        return Pairs(first, np.array([self._seconds(other, m, limit) for m, limit in enumerate(limits)]))

    def _seconds(self, racer: Racer, member: int, limit_s: float) -> float:
        build, budget = OPTIMISERS[racer.optimiser]
        case = self.models[racer.model]()
        problem, start = case.problem(racer.equation).member(member), case.parameters[member : member + 1]
        build(1).fit(problem, start, silent, NoCheckpoint())  # a warm-up: code is generated here
        continued, seconds = racer.optimiser in CONTINUED, 0.0
        checkpoint = MemoryCheckpoint() if continued else NoCheckpoint()
        while True:
            begun, before = self.clock(), seconds if continued else 0.0
            fitted = build(budget).fit(problem, start, silent, checkpoint)
            seconds = before + self.clock() - begun
            if self.error(racer.model, torch.as_tensor(fitted.parameters), member) <= self.size.threshold:
                return seconds
            if seconds > limit_s:
                return math.inf
            budget = math.ceil(GROWTH * budget)

    def error(self, model: str, parameters: Tensor, member: int) -> float:
        """MAE_tau on a member's training samples, for either equation; parameters (1, n_parameters)."""
        case = self.models[model]()
        (task,) = case.problem("inverse").member(member).tasks
        tau = case.model.evaluate(parameters.double(), task.prepared).tau
        return math.inf if tau is None else (tau - task.measured["tau"]).abs().mean().item()
