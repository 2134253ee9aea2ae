"""Basis selection (III-A.1): which of many candidate terms make up L."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from repro.learning.optimiser_options import OptimiserOptions
from repro.learning.optimisers.least_squares import regression, solve
from repro.learning.result import Checkpoint, Fitted, Notes, Progress, Weights
from repro.learning.training_problem import TrainingProblem
from repro.plugins.options import NotNegative


@dataclass(frozen=True)
class Selection(OptimiserOptions):
    """optimiser=thresholded_least_squares and lasso: sparse regression on columns of unit norm, gauge columns dropped.

    A column that is zero on all data (a total derivative dF/dt) cannot be seen in tau: it is dropped and named in the
    notes.

    method `thresholded`: sequentially thresholded least squares (Brunton et al. 2016), a term stays while its share of
    the signal is at least `threshold`; `lasso`: coordinate descent (scikit-learn) with weight `penalty` of the absolute
    coefficients, and with `refit` least squares on the terms that remain.
    """

    linear_only: ClassVar[bool] = True
    selects: ClassVar[bool] = True

    method: Literal["thresholded", "lasso"] = "thresholded"
    threshold: NotNegative = 0.05
    penalty: NotNegative = 1e-2
    refit: bool = True

    def fit(self, problem: TrainingProblem, parameters: Weights, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Select and fit, member by member; of the start (member, n_parameters) fixed weights alone are kept."""
        solutions, gauge = [], []
        fixed = problem.model.fixed
        for member, start in enumerate(np.asarray(parameters, dtype=float)):
            matrix, right = regression(problem, member)
            norms = np.linalg.norm(matrix, axis=0)
            is_shown, is_free = norms > 1e-10 * norms.max(), np.ones(len(norms), dtype=bool)
            is_free[fixed] = False
            gauge.append(np.flatnonzero(is_free & ~is_shown))
            shown, solution = np.flatnonzero(is_free & is_shown), np.where(is_free, 0.0, start)
            right = right - matrix[:, fixed] @ start[fixed]
            solution[shown] = self._select(matrix[:, shown] / norms[shown], right) / norms[shown]
            solutions.append(solution)
            progress((member + 1) / problem.members, f"member {member + 1}")
        names = problem.model.coefficient_names
        notes = Notes(epochs=0, gauge_columns=[names[column] for column in gauge[0]])
        return Fitted(np.stack(solutions), [], ["ok"] * problem.members, notes)

    def _select(self, matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
        if self.method == "thresholded":
            return thresholded_least_squares(matrix, right, self.threshold)
        from sklearn.linear_model import Lasso

        spread = np.linalg.norm(right)
        lasso = Lasso(alpha=self.penalty / len(right), fit_intercept=False, max_iter=100_000, tol=1e-8)
        coefficients: np.ndarray = lasso.fit(matrix, right / spread).coef_ * spread
        if not self.refit:
            return coefficients
        retained = np.flatnonzero(coefficients)
        coefficients[retained] = solve(matrix[:, retained], right, 1e-12)[0]
        return coefficients


Options = Selection


def thresholded_least_squares(matrix: np.ndarray, right: np.ndarray, threshold: float) -> np.ndarray:
    """Least squares on unit columns, drop the terms below threshold |right|, repeat until nothing is dropped."""
    retained = np.arange(matrix.shape[1])
    coefficients = np.zeros(matrix.shape[1])
    while len(retained):
        solution, _ = solve(matrix[:, retained], right, 1e-12)
        large = np.abs(solution) >= threshold * np.linalg.norm(right)
        if large.all():
            coefficients[retained] = solution
            break
        retained = retained[large]
    return coefficients
