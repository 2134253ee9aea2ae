"""The subject of a comparison: a network with random weights, one batch of samples per member, and a training step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset
from repro.data.random_force import random_force
from repro.errors import UserError
from repro.learning.native import native
from repro.learning.objective import Objective
from repro.learning.objective_options import OBJECTIVES
from repro.learning.training import make_task
from repro.learning.training_problem import TrainingProblem
from repro.mechanics.system import load
from repro.models.bases import raw
from repro.models.kinds.structured import Options, Structured
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.plugins.plugin import plugin

Step = Callable[[], tuple[np.ndarray, np.ndarray]]  # loss (member,), gradient (member, n_parameters)
ModelOf = Callable[[Dataset], Model]
Equation = Literal["inverse", "forward"]
Precision = Literal["float64", "float32"]
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
        task = make_task(self.model, self.dataset, Objective(plugin(OBJECTIVES, equation).Options()))
        return TrainingProblem(self.model, [task], range(self.members))

    def measured(self, name: str) -> Tensor:
        """One measured quantity, (member, sample, n_q)."""
        return torch.from_numpy(getattr(self.dataset, name))


def network(basis: ModuleType, hidden: Sequence[int]) -> ModelOf:
    """A network for T (or L) of a basis."""
    return lambda data: Lagrangian(basis, data.n_q, hidden=hidden)


def triangular(hidden: Sequence[int]) -> ModelOf:
    """The mass matrix by its triangular factor from a network without a linear path, as in DeLaN."""
    options = Options(
        hidden=tuple(hidden), activation="softplus", skip=False, factor="triangular", initialisation="glorot"
    )
    return lambda data: Structured(data.n_q, np.ones(data.n_q), options)


def wide(hidden: Sequence[int]) -> ModelOf:
    """The mass matrix by this project's wide factor."""
    return lambda data: Structured(data.n_q, data.train.qd[0].std(0), Options(hidden=tuple(hidden)))


def pendulum_case(model: ModelOf, members: int, samples: int) -> TrainingCase:
    """Such a model on the single pendulum."""
    dataset = pendulum(range(members), samples)
    return started(model(dataset), dataset)


def random_case(n_q: int, hidden: Sequence[int], samples: int) -> TrainingCase:
    """One network L(q, qd) on random states; its cost depends on `samples` and n_q alone."""
    q, qd, qdd, tau = np.random.default_rng(0).normal(size=(4, 1, samples, n_q))
    dataset = Dataset(
        q=q, qd=qd, qdd=qdd, tau=tau, time=np.arange(samples, dtype=float), episode=np.zeros(samples, dtype=int),
        n_train=samples, coordinates=load("cart_rods", n=max(1, n_q - 1)).coordinates[:n_q], time_step=1.0,
    )  # fmt: skip
    return started(Lagrangian(raw, n_q, hidden=hidden), dataset)


def pendulum(seeds: Sequence[int], samples: int) -> Dataset:
    """The single pendulum under a random force, in short episodes."""
    return random_force(load(PENDULUM), seeds, RandomForce(samples=samples, episode_steps=EPISODE_STEPS))


def started(model: Model, dataset: Dataset) -> TrainingCase:
    """A model with random weights, one draw per member."""
    generators = [np.random.default_rng([seed, 1]) for seed in range(dataset.members)]
    return TrainingCase(model, torch.from_numpy(model.initial(generators)), dataset)


def torch_step(case: TrainingCase, equation: Equation) -> Step:
    """Jets of the network in torch, and one backward pass; the features' derivatives are prepared beforehand."""
    return differentiated(case.problem(equation).loss, case.parameters)


def native_step(case: TrainingCase, equation: Equation, precision: Precision = "float64") -> Step:
    """Compiled C, member by member. Raises UserError for a model without compiled code."""
    compiled = native(case.problem(equation), getattr(np, precision))
    if compiled is None:
        raise UserError("no compiled code for this model: it needs a C compiler, and a kernel or a small model")
    weights = list(case.parameters.numpy().astype(precision))

    def step() -> tuple[np.ndarray, np.ndarray]:
        losses, gradients = zip(*(compiled.loss_and_gradient(m, w) for m, w in enumerate(weights)), strict=True)
        return np.array(losses), np.stack(gradients)

    return step


def differentiated(loss: Callable[[Tensor], Tensor], parameters: Tensor) -> Step:
    """A step from a loss (member,) of the weights (member, n_parameters), by autograd."""

    def step() -> tuple[np.ndarray, np.ndarray]:
        weights = parameters.detach().requires_grad_()
        value = loss(weights)
        (gradient,) = torch.autograd.grad(value.sum(), weights)
        return value.detach().numpy(), gradient.numpy()

    return step
