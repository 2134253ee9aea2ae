"""The error of states that are predicted over several samples, which needs no accelerations (neural ODE, SymODEN)."""

import math
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Literal

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.learning.objective import Objective
from repro.learning.objective_options import ObjectiveOptions
from repro.learning.objectives.balance import starts_of_windows
from repro.learning.training_problem import TrainingTask
from repro.mechanics.runge_kutta import rk4_step
from repro.models.model import Model
from repro.plugins.options import Count


@dataclass(frozen=True)
class Options(ObjectiveOptions):
    """Options of objective=prediction: what each is stands in conf/objective/prediction.yaml."""

    linearised: ClassVar[bool] = False
    needs_energies: ClassVar[bool] = False
    needs_force: ClassVar[bool] = False
    needs_accelerations: ClassVar[bool] = False
    needs_differentiable: ClassVar[bool] = True

    intervals: Count = 4
    scheme: Literal["rk4", "midpoint"] = "rk4"
    substeps: Count = 1

    def task(self, model: Model, dataset: Dataset, minimised: Objective) -> TrainingTask:
        """Successive windows of so many intervals."""
        return prediction_task(model, dataset, minimised, self)


@dataclass(frozen=True)
class PredictionTask(TrainingTask):
    """measured: q, qd, tau (member, window, 1 + intervals, n_q); step: s of each interval."""

    options: Options | None = None

    def residuals(self, model: Model, parameters: Tensor) -> Tensor:
        """Predicted minus recorded [q, qd] after each interval, (member, window, intervals 2 n_q), scaled as `rows`."""
        assert self.options is not None
        states = torch.cat([self.measured["q"], self.measured["qd"]], dim=-1)
        tau, steps = self.measured["tau"], self.measured["step"].unsqueeze(-1)

        def rate(state: Tensor, force: Tensor) -> Tensor:
            q, qd = state.chunk(2, dim=-1)
            return torch.cat([qd, model.acceleration_at(parameters, q, qd, force)], dim=-1)

        state, errors = states[:, :, 0], []
        for interval in range(states.shape[2] - 1):
            force, after, step = tau[:, :, interval], states[:, :, interval + 1], steps[:, :, interval]
            if self.options.scheme == "midpoint":
                before = states[:, :, interval]
                state = before + step * rate((before + after) / 2, force)
            else:
                h = step / self.options.substeps
                for _ in range(self.options.substeps):
                    state = rk4_step(partial(rate, force=force), state, h)
            errors.append(state - after)
        return torch.cat(errors, dim=-1) / math.sqrt(len(errors) * self.samples)


def prediction_task(model: Model, dataset: Dataset, objective: Objective, options: Options) -> PredictionTask:
    """Successive windows within the episodes of a dataset; UserError where no episode is as long as a window."""
    first = starts_of_windows(dataset.episode, options.intervals)
    if not len(first):
        raise UserError(f"objective.intervals = {options.intervals}: no episode is longer; shorten it")
    sample = first[:, None] + np.arange(options.intervals + 1)
    measured = {name: getattr(dataset, name)[:, sample] for name in ("q", "qd", "tau")}
    step = np.diff(dataset.time[sample], axis=1)
    step = np.where(np.isclose(step, step[:, :1], rtol=1e-9), step[:, :1], step)  # even stamps differ by rounding
    measured["step"] = np.repeat(step[None], dataset.members, axis=0)
    tensors = {name: torch.from_numpy(np.ascontiguousarray(array)) for name, array in measured.items()}
    return PredictionTask(model, objective, tensors, known={}, options=options)
