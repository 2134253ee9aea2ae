"""The subject of a comparison: a network with random weights, and one batch of samples per member."""

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from repro.data.dataset import Dataset
from repro.data.random_force import random_force
from repro.learning import objective_options
from repro.learning.objective import Objective
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import raw
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.structured import Structured

Equation = Literal["inverse", "forward"]
PENDULUM = "sip"
EPISODE_STEPS = 100


@dataclass(frozen=True)
class TrainingCase:
    """A model, its weights (member, n_parameters) and the samples (member, sample, n_q) that it is trained on."""

    model: Model
    parameters: Tensor
    dataset: Dataset

    @property
    def members(self) -> int:
        """Number of members."""
        return len(self.parameters)

    def problem(self, equation: Equation) -> TrainingProblem:
        """The training problem of this engine."""
        task = make_task(self.model, self.dataset, Objective(objective_options.Equation(equation)))
        return TrainingProblem(self.model, [task], range(self.members))

    def measured(self, name: str) -> Tensor:
        """One measured quantity, (member, sample, n_q)."""
        return torch.from_numpy(getattr(self.dataset, name))


def lagrangian_case(basis: ModuleType, hidden: Sequence[int], members: int, samples: int) -> TrainingCase:
    """A network for T (or L) of a basis, on the single pendulum."""
    dataset = pendulum(range(members), samples)
    return _started(Lagrangian(basis, dataset.n_q, hidden=hidden), dataset)


def triangular_case(hidden: Sequence[int], members: int, samples: int) -> TrainingCase:
    """The mass matrix by its triangular factor from a network without a linear path, as in DeLaN."""
    dataset = pendulum(range(members), samples)
    model = Structured(
        dataset.n_q, np.ones(dataset.n_q), hidden=hidden, activation="softplus", skip=False, factor="triangular",
        initialisation="glorot",
    )  # fmt: skip
    return _started(model, dataset)


def random_case(n_q: int, hidden: Sequence[int], samples: int) -> TrainingCase:
    """One network L(q, qd) on random states; its cost depends on `samples` and n_q alone."""
    q, qd, qdd, tau = np.random.default_rng(0).normal(size=(4, 1, samples, n_q))
    dataset = Dataset(
        q=q, qd=qd, qdd=qdd, tau=tau, time=np.arange(samples, dtype=float), episode=np.zeros(samples, dtype=int),
        n_train=samples, coordinates=load("cart_rods", n=max(1, n_q - 1)).coordinates[:n_q], time_step=1.0,
    )  # fmt: skip
    return _started(Lagrangian(raw, n_q, hidden=hidden), dataset)


def pendulum(seeds: Sequence[int], samples: int) -> Dataset:
    """The single pendulum under a random force, in short episodes."""
    return random_force(load(PENDULUM), seeds=seeds, samples=samples, episode_steps=EPISODE_STEPS)


def _started(model: Model, dataset: Dataset) -> TrainingCase:
    generators = [np.random.default_rng([seed, 1]) for seed in range(dataset.members)]
    return TrainingCase(model, torch.from_numpy(model.initial(generators)), dataset)
