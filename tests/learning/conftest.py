"""Small problems on simulated data, and a checkpoint in memory."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
import torch
from simulated import free_motion, random_force

from repro.learning.objective import Objective
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import t1

TRUE_T1 = np.array([0.4, 0.025, 0.1, 0.98])  # m0 + m1, m1 l^2 over two, m1 l, m1 g l of Table I


class Memory:
    """A checkpoint that keeps the last state, and stops the fit at one of its saves."""

    def __init__(self, stop_at: int | None = None) -> None:
        self.state, self.saves, self.stop_at = None, 0, stop_at

    def load(self):
        return deepcopy(self.state)

    def save(self, state) -> None:
        self.state, self.saves = deepcopy(state), self.saves + 1
        if self.saves == self.stop_at:
            raise KeyboardInterrupt


@pytest.fixture
def memory():
    return Memory


@pytest.fixture(scope="session")
def system():
    return load("sip")


@pytest.fixture(scope="session")
def data(system):
    """135 training samples: no multiple of the lanes of the generated code."""
    return random_force(system, seeds=[0, 1, 2], samples=150, episode_steps=25, train_fraction=0.9)


@pytest.fixture(scope="session")
def free(system):
    return free_motion(system, seeds=[0, 1, 2], initial_angles=7, steps=3)


@pytest.fixture
def true_t1():
    return TRUE_T1


@pytest.fixture
def t1_problem(data):
    from repro.models.lagrangian import Lagrangian

    return _problem(Lagrangian(t1, 2), data)


@pytest.fixture
def make_problem():
    return _problem


@pytest.fixture
def start():
    return _start


@pytest.fixture
def spoilt(data):
    """The same data with one infinite force of the second member."""
    tau = data.tau.copy()
    tau[1, 17, 0] = np.inf
    return replace(data, tau=tau)


def _problem(model, data, objective=None, **options):
    task = make_task(model, data.train, objective or Objective(), **options)
    return TrainingProblem(model, [task], list(range(data.members)))


def _start(model, members=3, seed=0):
    """Random weights, biases too."""
    weights = model.initial([np.random.default_rng([seed, member]) for member in range(members)])
    return torch.from_numpy(weights + 0.1 * np.random.default_rng(seed).normal(size=weights.shape))
