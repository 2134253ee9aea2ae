"""The race to several accuracies: processor time of training until the errors on held-out samples are small enough."""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import ClassVar

import numpy as np
import torch
from torch import Tensor

from repro.bench.pairing import Clock, Pairs
from repro.bench.training_case import PENDULUM, ModelOf, TrainingCase, started
from repro.codegen.array_evaluation import evaluate
from repro.data.dataset import Dataset
from repro.evaluation.predictions import predict
from repro.learning.optimisers.adam import Adam
from repro.learning.optimisers.lbfgs import LBFGS
from repro.learning.optimisers.levenberg_marquardt import LevenbergMarquardt
from repro.learning.result import NoCheckpoint, silent
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import load
from repro.models.model import Model

METRICS = ("MAE_qdd", "MAE_H")  # that of H after one constant
RESOLUTION = 1.05  # errors are looked at whenever this many times the seconds have passed, which are known to it
ENDLESS = 10**6  # epochs or iterations: the time ends a training
OPTIMISERS = {
    "Adam": Adam(epochs=ENDLESS),
    "Adam, torch": Adam(epochs=ENDLESS, engine="torch"),
    "L-BFGS": LBFGS(iterations=ENDLESS),
    "Levenberg-Marquardt": LevenbergMarquardt(iterations=ENDLESS, restarts=1),
}

Weights = np.ndarray  # of one model, (n_parameters,)
Predictions = tuple[np.ndarray, np.ndarray]  # qdd (sample, n_q) in m/s^2 or rad/s^2, and H (sample,) in J


class OverError(Exception):
    """A training has reached all goals, or its time is over."""


@dataclass
class Course:
    """Errors (metric,) that one training has reached by which second; looks at the weights as a `Watch` does.

    A call raises OverError when no error is above `least`, or after `limit_s`, without looks, or `limit_steps` calls.
    """

    name: ClassVar[str] = "race"
    always: ClassVar[bool] = True

    measure: Callable[[Weights], np.ndarray]
    least: float
    limit_s: float
    clock: Clock = time.process_time
    limit_steps: int = ENDLESS
    seconds: list[float] = field(default_factory=list)
    errors: list[np.ndarray] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._begun, self._steps = self.clock(), 0

    def __call__(self, parameters: Tensor) -> np.ndarray:
        """Zero (1,), after a look at the weights (1, n_parameters) where it is time for one."""
        now, self._steps = self.clock(), self._steps + 1
        spent = now - self._begun
        if spent > self.limit_s or self._steps > self.limit_steps:
            raise OverError
        if not self.seconds or spent >= RESOLUTION * self.seconds[-1]:
            self.look(parameters, spent)
            self._begun += self.clock() - now
            if (self.errors[-1] <= self.least).all():
                raise OverError
        return np.zeros(1)

    def look(self, parameters: Tensor, spent: float) -> None:
        """Note the errors of weights (1, n_parameters)."""
        self.seconds.append(spent)
        self.errors.append(self.measure(parameters[0].double().numpy()))

    def member(self, index: int) -> "Course":
        """Itself: it is about one training."""
        return self

    def end(self, parameters: Tensor) -> None:
        """Look at what a training that ended by itself has found, (1, n_parameters)."""
        if (spent := self.clock() - self._begun) <= self.limit_s:
            self.look(parameters, spent)

    def seconds_to(self, metric: str, goal: float) -> float:
        """Seconds until an error was first at most `goal`; infinite where it never was."""
        errors = [each[METRICS.index(metric)] for each in self.errors]
        return next((s for s, error in zip(self.seconds, errors, strict=True) if error <= goal), np.inf)


@dataclass(frozen=True)
class Entrant:
    """What a racer does from its random start number m: train under a course, and predict held-out samples."""

    train: Callable[[int, Course], None]
    predict: Callable[[int, Weights], Predictions]


@dataclass(frozen=True)
class Racer:
    """An entrant by its label; it is made when the race begins."""

    label: str
    enter: Callable[[Dataset], Entrant]


@dataclass(frozen=True)
class Race:
    """Seconds from random starts, one per member of the data, until errors on the test part are below `goals`.

    Errors are shares of those of a model without motion or energy. All racers have `limit_s` seconds.
    """

    make: Callable[[], Dataset]
    goals: Sequence[float]
    limit_s: float
    clock: Clock = time.process_time
    _courses: dict[str, list[Course]] = field(default_factory=dict)

    @cached_property
    def data(self) -> Dataset:
        """The samples."""
        return self.make()

    def pairs(self, ours: Racer, other: Racer, metric: str, goal: float) -> Pairs:
        """Both racers from the same seeds, one pair per start."""
        first, second = (
            np.array([course.seconds_to(metric, goal) for course in self.courses(racer)]) for racer in (ours, other)
        )
        return Pairs(first, second)

    def courses(self, racer: Racer) -> list[Course]:
        """The courses of a racer, one per start; it runs once, however often it is compared."""
        if racer.label not in self._courses:
            entrant = racer.enter(self.data)
            self._run(entrant, 0, limit_steps=2)  # a warm-up: code is generated here
            self._courses[racer.label] = [self._run(entrant, start) for start in range(self.data.members)]
        return self._courses[racer.label]

    def _run(self, entrant: Entrant, start: int, limit_steps: int = ENDLESS) -> Course:
        def measure(weights: Weights) -> np.ndarray:
            return self.errors(start, *entrant.predict(start, weights))

        course = Course(measure, min(self.goals), self.limit_s, self.clock, limit_steps)
        with suppress(OverError):
            entrant.train(start, course)
        return course

    def errors(self, start: int, qdd: np.ndarray, energy: np.ndarray) -> np.ndarray:
        """Errors (metric,) of predictions on the test part of a start."""
        test = self.data.test
        true = evaluate(dynamics_of(load(PENDULUM)).hamiltonian, test.q[start], test.qd[start])[:, 0]
        wrong = energy - true
        of_energy = np.abs(wrong - wrong.mean()).mean() / np.abs(true - true.mean()).mean()
        return np.array([np.abs(qdd - test.qdd[start]).mean() / np.abs(test.qdd[start]).mean(), of_energy])


def racer(name: str, make: ModelOf, problem_of: Callable[[TrainingCase], TrainingProblem], optimiser: str) -> Racer:
    """A model under one of this project's optimisers, at the default settings but for one start and no end."""

    def enter(data: Dataset) -> Entrant:
        case = started(make(data), data.train)
        problem = problem_of(case)

        def train(start: int, course: Course) -> None:
            watched = replace(problem.member(start), watches=[course])
            fitted = OPTIMISERS[optimiser].fit(watched, case.parameters[start : start + 1], silent, NoCheckpoint())
            course.end(torch.as_tensor(fitted.parameters))

        return Entrant(train, partial(_predicted, case.model, data.test))

    return Racer(f"{name}, {optimiser}", enter)


def _predicted(model: Model, test: Dataset, start: int, weights: Weights) -> Predictions:
    q, qd, qdd, tau = (array[start : start + 1] for array in (test.q, test.qd, test.qdd, test.tau))
    terms = predict(model, weights[None], q, qd, qdd, tau)
    return terms.acceleration[0], terms.hamiltonian(qd)[0]
