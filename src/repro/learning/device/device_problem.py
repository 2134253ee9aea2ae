"""A fitting problem whose data lie on a device, where its loss is computed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode

from repro.learning.device.steps import Steps
from repro.learning.training_problem import TrainingProblem


class KeptIndices(TorchFunctionMode):
    """Within it a list that indexes a tensor is sent to the tensor's device once, not at every use.

    A CUDA graph cannot be captured while numbers come from the host.
    """

    def __init__(self) -> None:
        super().__init__()
        self._kept: dict[tuple[tuple[int, ...], torch.device], Tensor] = {}

    def __torch_function__(
        self,
        func: Callable[..., Any],
        types: Sequence[type],
        args: tuple[Any, ...] = (),
        kwargs: Mapping[str, Any] | None = None,
    ) -> Any:
        """Pass everything on, indexing with its lists replaced."""
        if func is Tensor.__getitem__ and isinstance(args[1], tuple):
            args = args[0], tuple(self._index(part, args[0].device) for part in args[1])
        return func(*args, **(kwargs or {}))

    def _index(self, part: Any, device: torch.device) -> Any:
        if not isinstance(part, list):
            return part
        key = tuple(part), device
        if key not in self._kept:
            self._kept[key] = torch.tensor(part, device=device)
        return self._kept[key]


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
        tasks = [task.ready().changed(lambda tensor: tensor.to(device)) for task in same.tasks]
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
