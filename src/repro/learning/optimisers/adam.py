"""Adam as the paper's Keras runs it, plain or with a cosine schedule; and stochastic gradient descent."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.learning.native import NativeProblem, native, shuffled
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.result import Checkpoint, Curve, Fitted, Notes, Progress, Weights
from repro.learning.training_problem import TrainingProblem
from repro.plugins.options import Count, NotNegative, Positive

Constants = tuple[float, float, float]  # the decay of both moments, and epsilon

BETA_1, BETA_2 = 0.9, 0.999
GRADIENT: Constants = (0.0, 1.0, 1.0)  # with these a step of Adam is the gradient itself


@dataclass
class AdamState:
    """Where a fit stands: weights, the last finite ones, and both moments (member, n_parameters); alive: (member,)."""

    parameters: Tensor
    finite: Tensor
    first: Tensor
    second: Tensor
    alive: Tensor
    status: list[str]
    epoch: int = 0
    seconds: float = 0.0
    curves: Curve = field(default_factory=list)

    @classmethod
    def start(cls, parameters: Tensor) -> "AdamState":
        """Before the first epoch."""
        moments = torch.zeros_like(parameters), torch.zeros_like(parameters)
        alive = torch.ones(len(parameters), dtype=torch.bool)
        return cls(parameters.clone(), parameters.clone(), *moments, alive, ["ok"] * len(parameters))


@dataclass(frozen=True)
class Adam(OptimiserOptions):
    """optimiser=adam, adam_cosine and sgd: Adam (Kingma and Ba 2015) in the form of legacy Keras.

    The step is lr sqrt(1 - b2^k) / (1 - b1^k) m / (sqrt(v) + epsilon). A member whose loss is no longer finite is put
    back to its last finite weights and left there.

    rule `sgd`: plain gradient descent on the same batches, without moments, momentum or epsilon.
    schedule `keras`: learning rate / (1 + decay k) at step k; `cosine`: down to 1e-4 of it along half a cosine. engine
    `auto`: compiled code where a compiler and a kernel for model and precision exist, else torch. precision: Keras's
    default is float32, which only networks of features have a kernel for. budget_s: CPU seconds per member, looked at
    after every epoch; the cosine then falls along the share of it that is spent, and `epochs` are the most.
    """

    unit: ClassVar[Literal["epochs", "iterations"] | None] = "epochs"
    handles_l1: ClassVar[bool] = True
    runs_on_device: ClassVar[bool] = True

    epochs: Count = 1000
    learning_rate: NotNegative = 0.01
    decay: NotNegative = 1e-6
    rule: Literal["adam", "sgd"] = "adam"
    schedule: Literal["keras", "cosine"] = "keras"
    batch_size: Count = 2048
    epsilon: Positive = 1e-7
    curve_points: Count = 200
    engine: Literal["auto", "torch"] = "auto"
    precision: Literal["float64", "float32"] = "float64"
    budget_s: Positive | None = None

    def fit(self, problem: TrainingProblem, parameters: Weights, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Train from `parameters` (member, n_parameters)."""
        dtype, real = (torch.float64, np.float64) if self.precision == "float64" else (torch.float32, np.float32)
        compiled = native(problem, real) if self.engine == "auto" else None
        problem = problem if compiled is not None else problem.cast(dtype)
        state = checkpoint.load()
        if not isinstance(state, AdamState):
            state = AdamState.start(torch.as_tensor(parameters).to(dtype))
        batches = math.ceil(problem.samples / self.batch_size)
        every = max(1, self.epochs // self.curve_points)
        budget = math.inf if self.budget_s is None else self.budget_s * problem.members
        started = time.process_time() - state.seconds
        for epoch in range(state.epoch, self.epochs):
            before = state.seconds / budget
            rates = self._rates(epoch * batches, batches, before)
            if compiled is None:
                losses = self._torch_epoch(problem, state, rates, epoch)
            else:
                losses = self._native_epoch(compiled, problem.seeds, state, rates, epoch)
            _watch(state, losses, epoch)
            state.epoch, state.seconds = epoch + 1, time.process_time() - started
            spent = state.seconds >= budget
            is_point = epoch % every == 0 or epoch == self.epochs - 1 or spent
            is_point |= int(state.seconds / budget * self.curve_points) > int(before * self.curve_points)
            if is_point:
                state.curves.append((epoch + 1, "loss", losses.double().numpy().copy()))
            state.curves += [
                (epoch + 1, watch.name, watch(state.parameters))
                for watch in problem.watches
                if watch.always or is_point
            ]
            checkpoint.save(state)
            share = max((epoch + 1) / self.epochs, min(state.seconds / budget, 1.0))
            progress(share, f"epoch {epoch + 1} of {self.epochs}, loss {losses.nanmedian():.2e}")
            if spent:
                break
        return Fitted(state.parameters, state.curves, state.status, Notes(epochs=state.epoch))

    def rate(self, step: int, total: int) -> float:
        """Learning rate at step 0, 1, ... of `total`, without the bias correction."""
        if self.schedule == "keras":
            return self.learning_rate / (1 + self.decay * step)
        return self.learning_rate * (1e-4 + (1 - 1e-4) * 0.5 * (1 + math.cos(math.pi * step / total)))

    @property
    def constants(self) -> Constants:
        """The decay of both moments, and epsilon."""
        return GRADIENT if self.rule == "sgd" else (BETA_1, BETA_2, self.epsilon)

    def _rates(self, first: int, count: int, spent: float) -> np.ndarray:
        """Step sizes of an epoch of `count` steps after `first` ones, which took the share `spent` of the budget."""
        total = max(round(first / spent), first + count) if spent else self.epochs * count
        steps = range(first, first + count)
        rates = np.array([self.rate(k, total) for k in steps])
        if self.rule == "sgd":
            return rates
        return rates * [math.sqrt(1 - BETA_2 ** (k + 1)) / (1 - BETA_1 ** (k + 1)) for k in steps]

    def _native_epoch(
        self, compiled: NativeProblem, seeds: Sequence[int], state: AdamState, rates: np.ndarray, epoch: int
    ) -> Tensor:
        losses = torch.full((len(seeds),), float("nan"), dtype=torch.float64)
        arrays = [tensor.numpy() for tensor in (state.parameters, state.first, state.second)]
        for member in state.alive.nonzero().flatten().tolist():
            order = shuffled(seeds[member], int(compiled.counts[0]), epoch)
            rows = [array[member] for array in arrays]
            losses[member] = compiled.adam_epoch(member, order, self.batch_size, rates, self.constants, rows)
        return losses

    def _torch_epoch(self, problem: TrainingProblem, state: AdamState, rates: np.ndarray, epoch: int) -> Tensor:
        order = torch.from_numpy(np.stack([shuffled(seed, problem.samples, epoch) for seed in problem.seeds])).long()
        losses = torch.zeros(problem.members, dtype=state.parameters.dtype)
        for batch, rate in enumerate(rates):
            index = order[:, batch * self.batch_size : (batch + 1) * self.batch_size]
            parameters = state.parameters.requires_grad_()
            loss = problem.loss(parameters, index)
            (gradient,) = torch.autograd.grad(loss.sum(), parameters)
            update = adam_step(gradient, state.first, state.second, float(rate), self.constants)
            parameters = parameters.detach()
            state.parameters = torch.where(state.alive.unsqueeze(1), parameters - update, parameters)
            losses += loss.detach() * index.shape[1] / problem.samples
        return losses


Options = Adam


def adam_step(gradient: Tensor, first: Tensor, second: Tensor, rate: float | Tensor, constants: Constants) -> Tensor:
    """What to subtract from the weights; updates both moments in place; constants: see `Adam.constants`."""
    beta_1, beta_2, epsilon = constants
    first.mul_(beta_1).add_(gradient, alpha=1 - beta_1)
    second.mul_(beta_2).addcmul_(gradient, gradient, value=1 - beta_2)
    return rate * first / (second.sqrt() + epsilon)


def _watch(state: AdamState, losses: Tensor, epoch: int) -> None:
    finite = losses.isfinite() & state.parameters.isfinite().all(1)
    for member in (state.alive & ~finite).nonzero().flatten().tolist():
        state.status[member] = f"diverged at epoch {epoch + 1}"
        state.parameters[member] = state.finite[member]
    state.alive &= finite
    state.finite = torch.where(state.alive.unsqueeze(1), state.parameters, state.finite)
