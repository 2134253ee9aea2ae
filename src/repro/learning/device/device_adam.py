"""Adam on a device, where all samples lie, for all members of an ensemble at once.

No value leaves the device before an epoch is over.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode

from repro.learning.device.cuda import Replay, captured, check_device
from repro.learning.optimisers.adam import Adam, AdamState, Constants, adam_step
from repro.learning.result import Checkpoint, Fitted, Notes, Progress, Weights
from repro.learning.training_problem import TrainingProblem


class Steps:
    """Adam's steps for all members of one problem at once; on a CUDA device every width of batch is a graph.

    not_captured: why the steps are no graph, where they could not be made one.
    """

    def __init__(self, problem: TrainingProblem, device: torch.device) -> None:
        self.problem, self.device = problem, device
        self.not_captured: str | None = None
        shape, dtype = (problem.members, problem.model.n_parameters), problem.tasks[0].measured["qd"].dtype
        zeros = partial(torch.zeros, dtype=dtype, device=device)
        self._parameters, self._first, self._second = zeros(shape), zeros(shape), zeros(shape)
        self._alive = torch.ones(problem.members, 1, dtype=torch.bool, device=device)
        self._losses, self._rate = zeros(problem.members), zeros(())
        self._ready: dict[tuple[int, Constants], tuple[Tensor, Replay]] = {}

    def epoch(self, state: AdamState, order: Tensor, rates: np.ndarray, batch: int, constants: Constants) -> Tensor:
        """One epoch from the state of `Adam`, on the host and updated; the mean loss (member,), on the host.

        order: (member, sample), on the device; rates: one per step.
        """
        parts = torch.split(order, batch, dim=1)
        steps = [self._step(part.shape[1], constants) for part in (parts[0], parts[-1])]
        own = self._parameters, self._first, self._second
        for mine, theirs in zip(own, (state.parameters, state.first, state.second), strict=True):
            mine.copy_(theirs)
        self._alive.copy_(state.alive.unsqueeze(1))
        self._losses.zero_()
        for part, rate in zip(parts, torch.from_numpy(rates).to(self._rate), strict=True):
            index, replay = steps[0] if part.shape[1] == parts[0].shape[1] else steps[1]
            index.copy_(part)
            self._rate.copy_(rate)
            replay()
        state.parameters, state.first, state.second = (mine.cpu() for mine in own)
        return self._losses.cpu()

    def _step(self, width: int, constants: Constants) -> tuple[Tensor, Replay]:
        """Where the batch's indices (member, width) go, and a step on them; making it spoils the state."""
        if (width, constants) not in self._ready:
            index = torch.zeros(self.problem.members, width, dtype=torch.int64, device=self.device)
            replay: Replay = partial(self._advance, index, constants)
            if self.device.type == "cuda":
                replay, self.not_captured = captured(replay)
            self._ready[width, constants] = index, replay
        return self._ready[width, constants]

    def _advance(self, index: Tensor, constants: Constants) -> None:
        parameters = self._parameters.detach().requires_grad_()
        loss = self.problem.loss(parameters, index)
        (gradient,) = torch.autograd.grad(loss.sum(), parameters)
        moved = self._parameters - adam_step(gradient, self._first, self._second, self._rate, constants)
        self._parameters.copy_(torch.where(self._alive, moved, self._parameters))
        self._losses.add_(loss.detach(), alpha=index.shape[1] / self.problem.samples)


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


@dataclass(frozen=True)
class DeviceAdam(Adam):
    """The steps of `Adam` on `device`, with the members as a batch axis and batches drawn there.

    The state goes to the device and comes back once an epoch, so that a checkpoint of it resumes anywhere.
    """

    device: str = "cuda"

    @classmethod
    def of(cls, adam: Adam, device: str) -> "DeviceAdam":
        """An Adam's settings, on a device."""
        return cls(**vars(adam) | {"engine": "torch", "device": device})

    def fit(self, problem: TrainingProblem, parameters: Weights, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Train from `parameters` (member, n_parameters), on the host like the result; UserError without the device.

        Notes: the device, and why the steps are no CUDA graph, where they should be.
        """
        check_device(self.device)
        resident = DeviceProblem.of(problem, torch.device(self.device), getattr(torch, self.precision))
        fitted = super().fit(resident, parameters, progress, checkpoint)
        notes = Notes(device=self.device, not_captured=resident.steps.not_captured)
        return replace(fitted, notes=fitted.notes | notes)

    def _torch_epoch(self, problem: TrainingProblem, state: AdamState, rates: np.ndarray, epoch: int) -> Tensor:
        assert isinstance(problem, DeviceProblem)
        drawn = device_order(problem.seeds, problem.samples, epoch, problem.device)
        return problem.steps.epoch(state, drawn, rates, self.batch_size, self.constants)


def device_order(seeds: Sequence[int], samples: int, epoch: int, device: torch.device) -> Tensor:
    """A fresh order of each member's samples, (member, sample), from (seed, epoch) alone: a resumed fit sees the same.

    It differs from the host's order: a shuffle on the host takes longer than an epoch of steps on a device. Random
    keys of all members are sorted at once, where a permutation of each would wait for the device.
    """
    generator = torch.Generator(device)
    keys = torch.empty(len(seeds), samples, dtype=torch.float64, device=device)
    for row, seed in zip(keys, seeds, strict=True):
        generator.manual_seed(int(np.random.SeedSequence([seed, 11, epoch]).generate_state(1, np.uint64)[0]))
        row.uniform_(generator=generator)
    return keys.argsort(dim=1)
