"""A fitting problem whose data lie on a device, where its loss is computed."""

from dataclasses import dataclass, field
from functools import cached_property

import torch
from torch import Tensor

from repro.learning.device.indices import KeptIndices
from repro.learning.device.steps import Steps
from repro.learning.training_problem import TrainingProblem, TrainingTask


@dataclass(frozen=True)
class DeviceProblem(TrainingProblem):
    """The same problem, with all members' samples on `device`: the weights and indices of its loss are there too."""

    device: torch.device = field(kw_only=True)
    _indices: KeptIndices = field(default_factory=KeptIndices)

    @classmethod
    def of(cls, problem: TrainingProblem, device: torch.device, dtype: torch.dtype) -> "DeviceProblem":
        """The problem with its tensors moved, in this floating-point type."""
        same = problem.cast(dtype)
        l1 = None if same.l1 is None else same.l1.to(device)
        tasks = [_moved(task, device) for task in same.tasks]
        return cls(problem.model, tasks, problem.seeds, l1, problem.watches, device=device)

    @property
    def dtype(self) -> torch.dtype:
        """Of all its numbers."""
        return self.tasks[0].measured["qd"].dtype

    def cast(self, dtype: torch.dtype) -> TrainingProblem:
        """As that of a problem; itself where it has this type already."""
        return self if dtype == self.dtype else super().cast(dtype)

    @cached_property
    def steps(self) -> Steps:
        """Adam's steps on this problem."""
        return Steps(self, self.device)

    def loss(self, parameters: Tensor, index: Tensor | None = None) -> Tensor:
        """As that of a problem; the tensors that it and its model make are made on the device."""
        with self.device, self._indices:
            return super().loss(parameters, index)


def _moved(task: TrainingTask, device: torch.device) -> TrainingTask:
    parts = {name: {k: v.to(device) for k, v in getattr(task, name).items()} for name in ("prepared", "measured")}
    weight = None if task.sample_weight is None else task.sample_weight.to(device)
    return TrainingTask(task.objective, **parts, sample_weight=weight)
