"""Adam on a device, all members of an ensemble at once."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from repro.learning.device.cuda import check_device
from repro.learning.device.device_problem import DeviceProblem
from repro.learning.optimisers.adam import Adam, AdamState
from repro.learning.result import Checkpoint, Fitted, Notes, Progress, Weights
from repro.learning.training_problem import TrainingProblem


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

    It differs from the host's order: a shuffle on the host takes longer than an epoch of steps on a device.
    """
    generator, rows = torch.Generator(device), []
    for seed in seeds:
        generator.manual_seed(int(np.random.SeedSequence([seed, 11, epoch]).generate_state(1, np.uint64)[0]))
        rows.append(torch.randperm(samples, generator=generator, device=device))
    return torch.stack(rows)
