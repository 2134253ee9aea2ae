"""One member's loss, gradient and Jacobian in float64: compiled where there is a kernel, torch otherwise."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import torch

from repro.learning.kernels.generated import GeneratedRows, generated_rows
from repro.learning.native import NativeProblem, can_compile, native
from repro.learning.training_problem import TrainingProblem

SOMETIMES = 10  # steps, for what is not watched always


@dataclass(frozen=True)
class MemberProblem:
    """The problem of one member as functions of its weights (n_parameters,)."""

    problem: TrainingProblem  # of this member alone
    watched: dict[str, dict[int, float]] = field(default_factory=dict)  # name of a watch -> step -> value

    def look(self, step: int, parameters: np.ndarray) -> None:
        """Let the problem's watches look at the weights of a step."""
        for watch in self.problem.watches:
            if watch.always or step % SOMETIMES == 0:
                value = watch(torch.from_numpy(parameters).unsqueeze(0))[0]
                self.watched.setdefault(watch.name, {})[step] = float(value)

    @cached_property
    def compiled(self) -> NativeProblem | None:
        """Compiled loss and gradient, where they apply."""
        return native(self.problem)

    @cached_property
    def compiled_rows(self) -> GeneratedRows | None:
        """Compiled rows, where they apply."""
        return generated_rows(self.problem) if can_compile() else None

    def loss_and_gradient(self, parameters: np.ndarray) -> tuple[float, np.ndarray]:
        """The loss and its gradient (n_parameters,), 0 at fixed weights; not finite where the model is singular."""
        loss, gradient = self._loss_and_gradient(parameters)
        gradient[self.problem.model.fixed] = 0.0
        return loss, gradient

    def linearise(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residual rows (n_rows,) and their Jacobian (n_rows, n_parameters), 0 at fixed weights."""
        rows, jacobian = self._linearise(parameters)
        jacobian[:, self.problem.model.fixed] = 0.0
        return rows, jacobian

    def _loss_and_gradient(self, parameters: np.ndarray) -> tuple[float, np.ndarray]:
        if self.compiled is not None:
            return self.compiled.loss_and_gradient(0, parameters)
        weights = torch.from_numpy(parameters.copy()).unsqueeze(0).requires_grad_()
        loss = self.problem.loss(weights)[0]
        (gradient,) = torch.autograd.grad(loss, weights)
        return loss.item(), gradient[0].numpy()

    def _linearise(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if self.compiled_rows is not None:
            return self.compiled_rows.linearise(0, parameters)
        rows, jacobian = self.problem.linearise(torch.from_numpy(parameters.copy()).unsqueeze(0))
        return rows[0].numpy(), jacobian[0].numpy()
