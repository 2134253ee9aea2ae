"""A fitting problem: one model, one or more datasets with an objective each, and the l1 terms of (7a)."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.learning.objective import Objective
from repro.learning.watch import Watch
from repro.models.model import Model, Prepared
from repro.models.terms import Terms


@dataclass(frozen=True)
class TrainingTask:
    """A model's objective on a dataset; every array is (member, sample, ...).

    recorded: q, qd, qdd, tau, and the energy where it is known; known: what the model needs of them, where it has been
    computed already. share: (member, sample, node) where a row is a weighted sum over nodes, as in an integral; then
    recorded and known are (member, sample, node, ...).
    """

    model: Model
    objective: Objective
    recorded: Mapping[str, np.ndarray | Tensor]
    sample_weight: np.ndarray | Tensor | None = None
    known: Prepared | None = None
    share: np.ndarray | Tensor | None = None

    @cached_property
    def measured(self) -> dict[str, Tensor]:
        """The recorded arrays as tensors, on the same memory."""
        return {name: torch.as_tensor(array) for name, array in self.recorded.items()}

    @cached_property
    def prepared(self) -> Prepared:
        """What the model needs of the data: often many times their size, so only computed where it is read."""
        if self.known is not None:
            return self.known
        arrays = self.model.prepare(*(self.measured[name].double().numpy() for name in ("q", "qd", "qdd", "tau")))
        return {name: torch.from_numpy(array).to(self.measured["qd"].dtype) for name, array in arrays.items()}

    def ready(self) -> "TrainingTask":
        """The same task, whose parts need not compute again what the model needs of the data."""
        return replace(self, known=self.prepared)

    @property
    def points(self) -> Prepared:
        """What the model needs, nodes in the place of samples where there are any."""
        return self.prepared if self.share is None else _flat(self.prepared)

    @property
    def samples(self) -> int:
        """Number of samples per member."""
        return self.recorded["qd"].shape[1]

    def select(self, index: Tensor) -> "TrainingTask":
        """The samples `index` (member, batch) of each member."""
        members = torch.arange(len(index)).unsqueeze(1)
        return self.changed(lambda tensor: tensor[members, index])

    def member(self, index: int) -> "TrainingTask":
        """The same task for one member alone."""
        return self.changed(lambda tensor: tensor[index : index + 1])

    def cast(self, dtype: "torch.dtype") -> "TrainingTask":
        """The same task in another floating-point type; what the model needs is computed before it is rounded."""
        if dtype == self.measured["qd"].dtype:
            return self
        return self.ready().changed(lambda tensor: tensor.to(dtype))

    def changed(self, change: Callable[[Tensor], Tensor]) -> "TrainingTask":
        """The same task with every tensor changed."""
        prepared = vars(self).get("prepared", self.known)
        return replace(
            self,
            recorded={name: change(tensor) for name, tensor in self.measured.items()},
            sample_weight=None if self.sample_weight is None else change(torch.as_tensor(self.sample_weight)),
            known=None if prepared is None else {name: change(tensor) for name, tensor in prepared.items()},
            share=None if self.share is None else change(torch.as_tensor(self.share)),
        )

    def residuals(self, model: Model, parameters: Tensor) -> Tensor:
        """The rows (member, sample, row) of predictions at these weights (member, n_parameters), scaled as `rows`."""
        return self.rows(model.evaluate(parameters, self.points, self.objective.mass))

    def rows(self, terms: Terms) -> Tensor:
        """Residual rows (member, sample, row), scaled so that the sum of their squares is the mean over samples."""
        if self.share is None:
            rows = self.objective.rows(terms, self.measured)
        else:
            of_nodes = self.objective.rows(terms, _flat(self.measured))
            rows = (of_nodes.unflatten(1, self.share.shape[1:]) * torch.as_tensor(self.share).unsqueeze(-1)).sum(2)
        if self.sample_weight is not None:
            rows = rows * torch.as_tensor(self.sample_weight).sqrt().unsqueeze(-1)
        return rows / math.sqrt(self.samples)


@dataclass(frozen=True)
class TrainingProblem:
    """Minimise, for every member, the sum of its tasks' mean squared rows + l1 |coefficients|.

    l1: (n_parameters,) weights of the absolute values; seeds: one per member, for the batch order; watches: what to
    look at on the way.
    """

    model: Model
    tasks: Sequence[TrainingTask]
    seeds: Sequence[int]
    l1: Tensor | None = None
    watches: Sequence[Watch] = ()

    @property
    def members(self) -> int:
        """Number of members."""
        return len(self.seeds)

    @property
    def samples(self) -> int:
        """Samples of the first task: an epoch goes once over these."""
        return self.tasks[0].samples

    def loss(self, parameters: Tensor, index: Tensor | None = None) -> Tensor:
        """Loss (member,); `index` (member, batch) picks a mini-batch of the first task, the others are used whole."""
        total: Tensor = torch.zeros(len(parameters), dtype=parameters.dtype)
        for number, task in enumerate(self.tasks):
            part = task if number or index is None else task.ready().select(index)
            total = total + part.residuals(self.model, parameters).square().sum((1, 2))
        if self.l1 is not None:
            total = total + parameters.abs() @ self.l1
        return total

    def member(self, index: int) -> "TrainingProblem":
        """The problem of one member alone."""
        tasks, watches = [task.member(index) for task in self.tasks], [watch.member(index) for watch in self.watches]
        return replace(self, tasks=tasks, seeds=[self.seeds[index]], watches=watches)

    def linearise(self, parameters: Tensor) -> tuple[Tensor, Tensor]:
        """All rows (member, n_rows) and their Jacobian (member, n_rows, n_parameters); l1 terms are left out."""
        values, jacobians = [], []
        for task in self.tasks:
            rows, jacobian = self.model.rows(parameters, task.points, task.rows, task.objective.mass)
            if task.share is not None:
                jacobian = jacobian.unflatten(2, task.share.shape[1:]).sum(3)
            values.append(rows.transpose(1, 2).flatten(1))
            jacobians.append(jacobian.flatten(1, 2))
        if len(self.tasks) == 1:
            return values[0], jacobians[0]  # a copy of a large Jacobian takes as long as its product with itself
        return torch.cat(values, dim=1), torch.cat(jacobians, dim=1)

    def cast(self, dtype: "torch.dtype") -> "TrainingProblem":
        """The same problem in another floating-point type."""
        l1 = None if self.l1 is None else self.l1.to(dtype)
        return replace(self, tasks=[task.cast(dtype) for task in self.tasks], l1=l1)

    def subsample(self, samples: int | None) -> "TrainingProblem":
        """The same problem with at most `samples` random samples in the first task (drawn by each member's seed)."""
        if samples is None or samples >= self.samples:
            return self
        draws = [np.random.default_rng([seed, 77]).permutation(self.samples)[:samples] for seed in self.seeds]
        first = self.tasks[0].select(torch.from_numpy(np.stack(draws)))
        return replace(self, tasks=[first, *self.tasks[1:]])


def _flat(nodes: Prepared) -> Prepared:
    """(member, sample, node, ...) as (member, sample and node, ...)."""
    return {name: tensor.flatten(1, 2) for name, tensor in nodes.items()}
