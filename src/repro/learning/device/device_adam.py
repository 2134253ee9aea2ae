"""Adam on a device, all members of an ensemble at once."""

from dataclasses import dataclass, fields, replace

import numpy as np
import torch
from torch import Tensor

from repro.learning.adam import Adam
from repro.learning.device import order
from repro.learning.device.cuda import check_device
from repro.learning.device.device_problem import DeviceProblem
from repro.learning.result import Checkpoint, Fitted, Progress
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
        settings = {field.name: getattr(adam, field.name) for field in fields(adam)}
        return cls(**settings | {"engine": "torch", "device": device})

    def fit(self, problem: TrainingProblem, parameters: Tensor, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Train from `parameters` (member, n_parameters), on the host like the result; UserError without the device.

        Notes: the device, and why the steps are no CUDA graph, where they should be.
        """
        check_device(self.device)
        resident = DeviceProblem.of(problem, torch.device(self.device), getattr(torch, self.precision))
        fitted = super().fit(resident, parameters, progress, checkpoint)
        notes = {"device": self.device, "not_captured": resident.steps.not_captured}
        return replace(fitted, notes=fitted.notes | notes)

    def _torch_epoch(self, problem: TrainingProblem, state: dict, rates: np.ndarray, epoch: int) -> Tensor:
        assert isinstance(problem, DeviceProblem)
        drawn = order.drawn(problem.seeds, problem.samples, epoch, problem.device)
        return problem.steps.epoch(state, drawn, rates, self.batch_size, self.epsilon)
