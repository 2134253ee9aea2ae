"""Epochs of Adam on a device: no value leaves it before an epoch is over."""

from functools import partial

import numpy as np
import torch
from torch import Tensor

from repro.learning.device.cuda import Replay, captured
from repro.learning.optimisers.adam import AdamState, Constants, adam_step
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
