"""Closed-form least squares for models that are linear in their parameters: the oracle of every table."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import torch
from scipy.linalg import lstsq, qr
from torch import Tensor

from repro.codegen.point_function import LEAST_POINTS
from repro.learning.optimiser import Optimiser
from repro.learning.optimisers.least_squares import Options
from repro.learning.result import Checkpoint, Fitted, Notes, Progress
from repro.learning.training_problem import TrainingProblem

BLOCK = LEAST_POINTS  # samples at a time: their features are compiled, and never stored together


@dataclass(frozen=True)
class LeastSquares(Options, Optimiser):
    """Of all least-squares solutions the one nearest to `regularise_towards`, in columns of unit norm.

    Singular values below `cutoff` of the largest count as zero: what the data do not show stays as it was, at zero or
    at the start, which is where gradient descent would leave it too. A later phase is nearest to the one before.
    """

    def fit(self, problem: TrainingProblem, parameters: Tensor, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Solve each member's problem; the start `parameters` (member, n_parameters) tell at least the shape."""
        solutions, ranks = [], []
        for member, start in enumerate(parameters.double().numpy()):
            matrix, right = regression(problem.member(member), parameters.shape[1])
            origin = start.copy() if self.regularise_towards == "start" else np.zeros_like(start)
            origin[problem.model.fixed] = start[problem.model.fixed]
            matrix[:, problem.model.fixed], right = 0.0, right - matrix @ origin
            solution, rank = solve(matrix, right, self.cutoff)
            solution[problem.model.fixed] = 0.0  # but for rounding it is so already
            solutions.append(origin + solution)
            ranks.append(rank)
            progress((member + 1) / problem.members, f"member {member + 1}")
        notes = Notes(rank=ranks, epochs=0)
        return Fitted(torch.from_numpy(np.stack(solutions)), [], ["ok"] * problem.members, notes)


def regression(problem: TrainingProblem, n_parameters: int) -> tuple[np.ndarray, np.ndarray]:
    """Matrix (at most n_parameters + 1 rows) and right-hand side of a one-member problem linear in its parameters.

    They are the triangle of all rows of the problem: the same least squares, norms and singular values.
    """
    rows = _triangle(_blocks(problem, n_parameters))
    return rows[:, :-1], rows[:, -1]


def _blocks(problem: TrainingProblem, n_parameters: int) -> Iterator[np.ndarray]:
    """Rows [Jacobian, -residual] of a linear problem, for some samples at a time."""
    zero = torch.zeros(1, n_parameters, dtype=torch.float64)
    for task in problem.tasks:
        for start in range(0, task.samples, BLOCK):
            part = task.changed(partial(_cut, start))
            rows, jacobian = replace(problem, tasks=[part]).linearise(zero)
            share = (part.samples / task.samples) ** 0.5
            yield share * np.column_stack([jacobian[0].numpy(), -rows[0].numpy()])


def _cut(start: int, tensor: Tensor) -> Tensor:
    return tensor[:, start : start + BLOCK]


def _triangle(blocks: Iterable[np.ndarray]) -> np.ndarray:
    """R of the QR of all rows (n_rows, n), at most n rows, from one block of rows after another.

    Sequential QR (Demmel et al. 2012): the triangle of the rows so far is factorised together with the next block, so
    that the condition number is never squared.
    """
    triangle: np.ndarray | None = None
    for block in blocks:
        rows = block if triangle is None else np.vstack([triangle, block])
        triangle = np.asarray(np.linalg.qr(rows, mode="r"))
    if triangle is None:
        raise ValueError("least squares of no rows at all")
    return triangle


def solve(matrix: np.ndarray, right: np.ndarray, cutoff: float) -> tuple[np.ndarray, int]:
    """Minimum-norm solution on columns of unit norm, and the rank; a QR first keeps tall problems cheap."""
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    n = matrix.shape[1]
    triangle = qr(np.column_stack([matrix / scale, right]), mode="r")[0][: n + 1]
    solution, _, rank, _ = lstsq(triangle[:, :n], triangle[:, n], cond=cutoff)
    return solution / scale, int(rank)


def streamed_solve(blocks: Iterable[tuple[np.ndarray, np.ndarray]], cutoff: float) -> tuple[np.ndarray, int]:
    """Least squares of more samples than memory holds: of all blocks (matrix (rows, n), right (rows,)), and rank."""
    triangle = _triangle(np.column_stack(block) for block in blocks)
    return solve(triangle[:, :-1], triangle[:, -1], cutoff)
