"""One member's loss, gradient and Jacobian in float64: compiled where there is a kernel, torch otherwise."""

import math
import time
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from repro.codegen.lanes import can_compile
from repro.codegen.lazy_torch import torch
from repro.learning.kernels.generated import NormalEquations, normal_equations
from repro.learning.kernels.kernel import ENDLESS, Evaluations
from repro.learning.native import NativeProblem, native
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.models.inverse_jacobians import inverse_model

TOGETHER = 4096  # nodes of rows that are integrals: their Jacobians stay small
SOMETIMES = 10  # steps, for what is not watched always
# Multiples of what BLAS adds up at once (128, 320 or 384 rows) and of its tiles: sums without the zeros round alike.
ROWS, COLUMNS = 1920, 8


class IntegratedRows:
    """One member's loss, J'J and J'r of rows that are weighted sums over nodes, as those of the momentum balance are.

    They are made of the Jacobians of the inverse model at the nodes.
    """

    def __init__(self, task: TrainingTask) -> None:
        assert task.share is not None
        self.inverse, measured = inverse_model(task.model), task.measured
        self.points = np.concatenate([measured[name][0].numpy() for name in ("q", "qd", "qdd")], axis=-1)
        self.tau, self.share = measured["tau"][0].numpy(), np.asarray(task.share[0])
        weight = np.ones(len(self.share)) if task.sample_weight is None else np.asarray(task.sample_weight[0])
        self.factor = np.sqrt(weight / len(self.share))

    def loss(self, parameters: np.ndarray) -> float:
        """The sum of squared rows."""
        windows, nodes, _ = self.points.shape
        forces = self.inverse.forces(self.points.reshape(windows * nodes, -1), parameters)
        rows = np.einsum("wn,wni->wi", self.share, forces.reshape(self.tau.shape) - self.tau)
        return float(((rows * self.factor[:, None]) ** 2).sum())

    def normal_equations(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """J'J (n_parameters, n_parameters) and J'r (n_parameters,)."""
        both = np.zeros((1 + len(parameters), 1 + len(parameters)))
        windows, nodes, width = self.points.shape
        together = max(1, TOGETHER // nodes)
        for start in range(0, windows, together):
            part = slice(start, start + together)
            points = self.points[part].reshape(-1, width)
            linear = self.inverse.linear(points, parameters).reshape(-1, nodes, self.inverse.n_q * both.shape[0])
            rows = np.matmul(self.share[part, None], linear).reshape(-1, self.inverse.n_q, both.shape[0])
            rows[..., 0] -= np.einsum("wn,wni->wi", self.share[part], self.tau[part])
            flat = (rows * self.factor[part, None, None]).reshape(-1, both.shape[0])
            both += flat.T @ flat
        return both[1:, 1:], both[0, 1:]


def integrated_rows(problem: TrainingProblem) -> IntegratedRows | None:
    """Those of a member's problem with one task of that kind whose model is written as expressions, or None."""
    (task, *others) = problem.tasks
    if task.share is None or others or problem.model.not_symbolic is not None:
        return None
    return IntegratedRows(task)


def products(jacobian: np.ndarray, late: int) -> np.ndarray:
    """J'J of a Jacobian (n_rows, n_columns), cheaper where all columns from `late` on are 0 in its first rows.

    So are those of a momentum's own weights in the rows of motion, see eq. (8).
    """
    starts = range(0, len(jacobian), ROWS)
    start = next((start for start in starts if jacobian[start : start + ROWS, late:].any()), 0) if late else 0
    gram: np.ndarray = jacobian[start:].T @ jacobian[start:]
    if start:
        early = jacobian[:, : -(-late // COLUMNS) * COLUMNS]
        gram[:late, :late] = (early.T @ early)[:late, :late]
    return gram


@dataclass(frozen=True)
class MemberProblem:
    """The problem of one member as functions of its weights (n_parameters,)."""

    problem: TrainingProblem  # of this member alone
    evaluations: Evaluations = ENDLESS
    deadline: float = math.inf  # CPU seconds of this process
    watched: dict[str, dict[int, np.ndarray]] = field(default_factory=dict)  # name of a watch -> step -> value

    @property
    def out_of_time(self) -> bool:
        """Whether the budget is spent."""
        return time.process_time() > self.deadline

    def look(self, step: int, parameters: np.ndarray) -> None:
        """Let the problem's watches look at the weights of a step."""
        for watch in self.problem.watches:
            if watch.always or step % SOMETIMES == 0:
                value = watch(torch.from_numpy(parameters).unsqueeze(0))[0]
                self.watched.setdefault(watch.name, {})[step] = value

    @cached_property
    def compiled(self) -> NativeProblem | None:
        """Compiled loss and gradient, where they apply."""
        return native(self.problem, evaluations=self.evaluations)

    @cached_property
    def integrated(self) -> IntegratedRows | None:
        """Sums over rows that are integrals, where they apply."""
        return integrated_rows(self.problem)

    @cached_property
    def sums(self) -> IntegratedRows | NormalEquations | None:
        """These sums, or compiled ones, where they apply."""
        if self.integrated is not None or not can_compile():
            return self.integrated
        return normal_equations(self.problem, self.evaluations)

    def loss_and_gradient(self, parameters: np.ndarray) -> tuple[float, np.ndarray]:
        """The loss and its gradient (n_parameters,), 0 at fixed weights; not finite where the model is singular."""
        loss, gradient = self._loss_and_gradient(parameters)
        gradient[self.problem.model.fixed] = 0.0
        return loss, gradient

    def loss(self, parameters: np.ndarray) -> float:
        """The loss alone, for a problem without l1 terms."""
        if self.sums is not None:
            return self.sums.loss(parameters)
        with torch.no_grad():
            return self.problem.loss(torch.from_numpy(parameters.copy()).unsqueeze(0))[0].item()

    def normal_equations(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """J'J (n_parameters, n_parameters) and J'r (n_parameters,) of the residual rows r, 0 at fixed weights."""
        if self.sums is not None:
            gram, gradient = self.sums.normal_equations(parameters)
        else:
            rows, jacobian = self.linearise(parameters)
            transform = self.problem.model.transform_slice
            gram, gradient = products(jacobian, transform.start), jacobian.T @ rows
        fixed = self.problem.model.fixed
        gram[fixed] = gram[:, fixed] = gradient[fixed] = 0.0
        return gram, gradient

    def linearise(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residual rows (n_rows,) and their Jacobian (n_rows, n_parameters), 0 at fixed weights."""
        linear = self.problem.linearise(torch.from_numpy(parameters.copy()).unsqueeze(0))
        rows, jacobian = (part[0].numpy() for part in linear)
        jacobian[:, self.problem.model.fixed] = 0.0
        return rows, jacobian

    def _loss_and_gradient(self, parameters: np.ndarray) -> tuple[float, np.ndarray]:
        if self.compiled is not None:
            return self.compiled.loss_and_gradient(0, parameters)
        if self.integrated is not None and self.problem.l1 is None:
            return self.integrated.loss(parameters), 2 * self.integrated.normal_equations(parameters)[1]
        weights = torch.from_numpy(parameters.copy()).unsqueeze(0).requires_grad_()
        loss = self.problem.loss(weights)[0]
        (gradient,) = torch.autograd.grad(loss, weights)
        return loss.item(), gradient[0].numpy()
