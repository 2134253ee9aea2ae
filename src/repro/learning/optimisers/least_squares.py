"""Closed-form least squares for models that are linear in their parameters: the oracle of every table."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, Literal, Self

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.point_function import LEAST_POINTS
from repro.errors import UserError
from repro.learning.objective import Objective
from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.result import Checkpoint, Fitted, Notes, Progress, Weights
from repro.learning.symbolic import COLUMNS, symbols
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.models.model import Model
from repro.plugins.options import NotNegative

BLOCK = LEAST_POINTS  # samples at a time: their features are compiled, and never stored together


@dataclass(frozen=True)
class LeastSquares(OptimiserOptions):
    """Of all least-squares solutions the one nearest to `regularise_towards`, in columns of unit norm.

    Singular values below `cutoff` of the largest count as zero: what the data do not show stays as it was, at zero or
    at the start (`regularise_towards`), which is where gradient descent would leave it too.
    """

    linear_only: ClassVar[bool] = True

    cutoff: NotNegative = 1e-8
    regularise_towards: Literal["zero", "start"] = "zero"

    def continued(self) -> Self:
        """What the data of a later phase do not determine stays as the phases before have left it."""
        return replace(self, regularise_towards="start")

    def fit(self, problem: TrainingProblem, parameters: Weights, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Solve each member's problem; the start `parameters` (member, n_parameters) tell at least the shape."""
        solutions, ranks = [], []
        for member, start in enumerate(np.asarray(parameters, dtype=float)):
            matrix, right = regression(problem, member)
            origin = start.copy() if self.regularise_towards == "start" else np.zeros_like(start)
            origin[problem.model.fixed] = start[problem.model.fixed]
            matrix[:, problem.model.fixed], right = 0.0, right - matrix @ origin
            solution, rank = solve(matrix, right, self.cutoff)
            solution[problem.model.fixed] = 0.0  # but for rounding it is so already
            solutions.append(origin + solution)
            ranks.append(rank)
            progress((member + 1) / problem.members, f"member {member + 1}")
        notes = Notes(rank=ranks, epochs=0)
        return Fitted(np.stack(solutions), [], ["ok"] * problem.members, notes)


Options = LeastSquares


def regression(problem: TrainingProblem, member: int) -> tuple[np.ndarray, np.ndarray]:
    """Matrix (at most n_parameters + 1 rows) and right-hand side of one member's problem, linear in its parameters.

    They are the triangle of all rows of the problem: the same least squares, norms and singular values.
    UserError where squares of the data overflow.
    """
    rows = _triangle(block for task in problem.tasks for block in _blocks(task, member))
    with np.errstate(over="ignore"):
        if not np.isfinite(np.sum(rows**2)):
            raise UserError("the regression has infs: values of the data are too large to be squared")
    return rows[:, :-1], rows[:, -1]


def _blocks(task: TrainingTask, member: int) -> Iterator[np.ndarray]:
    """Rows [Jacobian, -residual] of a member's linear task, for some samples at a time."""
    weight = task.sample_weight
    weight = np.ones(task.samples) if weight is None else np.asarray(weight[member])
    share = None if task.share is None else np.asarray(task.share[member])
    recorded = {name: np.asarray(array[member]) for name, array in task.recorded.items()}
    columns = [recorded.get(name, np.zeros((*recorded["q"].shape[:-1], 1))) for name in COLUMNS[:5]]
    columns[4] = columns[4].reshape(*recorded["q"].shape[:-1], 1)
    function, n = linear_rows(task.model, task.objective), 1 + task.model.n_parameters
    for start in range(0, task.samples, BLOCK):
        part = slice(start, start + BLOCK)
        rows = evaluate(function, *(column[part] for column in columns))
        if share is not None:
            rows = np.einsum("wn,wni->wi", share[part], rows)
        yield ((weight[part, None] / task.samples) ** 0.5 * rows).reshape(-1, n)


@lru_cache(maxsize=16)
def linear_rows(model: Model, objective: Objective) -> casadi.Function:
    """[Jacobian, -residual] row by row, at weights of zero, as a function of q, qd, qdd, tau and energy."""
    s = symbols(model)
    rows = objective.expression(model, s)
    both = casadi.horzcat(casadi.jacobian(rows, s.parameters), -rows)
    at_zero = casadi.substitute(
        casadi.vec(both.T), casadi.vertcat(s.parameters, s.weight), casadi.vertcat(0 * s.parameters, 1)
    )
    return column_function("linear_rows", s.inputs[:5], at_zero)


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
    from scipy.linalg import lstsq, qr

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
