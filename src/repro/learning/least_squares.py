"""Closed-form least squares for models that are linear in their parameters: the oracle of every table."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import torch
from scipy.linalg import lstsq, qr
from torch import Tensor

from repro.learning.optimiser import Optimiser
from repro.learning.problem import Problem
from repro.learning.result import Checkpoint, Fitted, Progress


@dataclass(frozen=True)
class LeastSquares(Optimiser):
    """Minimum-norm least squares on normalised columns; singular values below `cutoff` of the largest count as zero."""

    linear_only: ClassVar[bool] = True

    cutoff: float = 1e-12

    def fit(self, problem: Problem, parameters: Tensor, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Solve each member's problem; `parameters` (member, n_parameters) tell the shape only."""
        solutions, ranks = [], []
        for member in range(problem.members):
            matrix, right = regression(problem.member(member), parameters.shape[1])
            solution, rank = solve(matrix, right, self.cutoff)
            solutions.append(solution)
            ranks.append(rank)
            progress((member + 1) / problem.members, f"member {member + 1}")
        return Fitted(torch.from_numpy(np.stack(solutions)), [], ["ok"] * problem.members, {"rank": ranks, "epochs": 0})


def regression(problem: Problem, n_parameters: int) -> tuple[np.ndarray, np.ndarray]:
    """Matrix (n_rows, n_parameters) and right-hand side (n_rows,) of a one-member problem linear in its parameters."""
    rows, jacobian = problem.linearise(torch.zeros(1, n_parameters, dtype=torch.float64))
    return jacobian[0].numpy(), -rows[0].numpy()


def solve(matrix: np.ndarray, right: np.ndarray, cutoff: float) -> tuple[np.ndarray, int]:
    """Minimum-norm solution on columns of unit norm, and the rank; a QR first keeps tall problems cheap."""
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0] = 1.0
    n = matrix.shape[1]
    triangle = qr(np.column_stack([matrix / scale, right]), mode="r")[0][: n + 1]
    solution, _, rank, _ = lstsq(triangle[:, :n], triangle[:, n], cond=cutoff)
    return solution / scale, int(rank)
