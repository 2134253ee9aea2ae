"""Levenberg-Marquardt."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from repro.learning.full_batch import FullBatch, Solution
from repro.learning.members import MemberProblem
from repro.learning.result import Progress, silent
from repro.plugins.options import Count, NotNegative, Positive

INCREASE = 4.0  # of the damping after a failed step


@dataclass(frozen=True)
class LevenbergMarquardt(FullBatch):
    """Damped Gauss-Newton steps (J'J + lambda D) d = -J'r (Marquardt 1963), full batch of `samples` per member.

    D is the largest diagonal of J'J so far (More 1978). lambda rises fourfold after a failure. It stops after
    `iterations`, or when twenty steps in a row stall or fail.

    damping: at the start, divided by `damping_decrease` after a success (3 suits free-form networks, 10 models that
    contain the truth). tolerance: a step that gains less than this share of the loss counts as stalled. restarts:
    random starts, tried for `trial_iterations` each; the one with the lowest training loss goes on.
    """

    linearises: ClassVar[bool] = True

    iterations: Count = 300
    samples: Count | None = 3000
    damping: NotNegative = 1.0
    damping_decrease: Positive = 3.0
    tolerance: NotNegative = 1e-10
    restarts: Count = 8
    trial_iterations: Count = 40

    def shortened(self, share: float) -> Self:
        """The same for a share of the iterations, those of the trials too, or of the budget."""
        trial = self.trial_iterations if self.budget_s else math.ceil(share * self.trial_iterations)
        return replace(super().shortened(share), trial_iterations=trial)

    def continued(self) -> Self:
        """A later phase starts from the weights of the one before."""
        return replace(self, restarts=1)

    @property
    def evaluations(self) -> int:
        """About how often the fit of a member evaluates its problem, from all starts."""
        return self.iterations + (self.restarts * self.trial_iterations if self.restarts > 1 else 0)

    def solve(self, problem: MemberProblem, start: np.ndarray, progress: Progress) -> Solution:
        """Minimise from the weights `start` (n_parameters,), or from the best of several starts."""
        return self._descend(problem, self._scout(problem, start), progress)

    def _scout(self, problem: MemberProblem, start: np.ndarray) -> np.ndarray:
        if self.restarts == 1:
            return start
        (seed,) = problem.problem.seeds
        model = problem.problem.model
        others = model.initial([np.random.default_rng([seed, 2, k]) for k in range(self.restarts - 1)])
        others[:, model.upstream] = start[model.upstream]
        short = replace(self, iterations=self.trial_iterations)
        tries = [short._descend(problem, candidate, silent, followed=False) for candidate in (start, *others)]
        return min(tries, key=lambda result: result[1][-1] if np.isfinite(result[1][-1]) else np.inf)[0]

    def _descend(
        self, problem: MemberProblem, parameters: np.ndarray, progress: Progress, followed: bool = True
    ) -> Solution:
        loss, damping, stalled = problem.loss(parameters), self.damping, 0
        losses = [loss]
        if followed:  # what is watched in a trial belongs to no step of the fit
            problem.look(0, parameters)
        if not np.isfinite(loss):
            return parameters, losses, "diverged at step 0"
        moved, scale = True, np.zeros_like(parameters)
        for iteration in range(self.iterations):
            if moved:  # only now, so that no step is prepared that is not taken
                gram, gradient = problem.normal_equations(parameters)
                scale = np.maximum(scale, gram.diagonal())
            trial = parameters + damped_step(gram, gradient, damping * scale)
            trial_loss = problem.loss(trial)
            moved = bool(trial_loss < loss)
            if moved:
                stalled = stalled + 1 if loss - trial_loss < self.tolerance * loss else 0
                parameters, loss, damping = trial, trial_loss, max(damping / self.damping_decrease, 1e-15)
            else:
                stalled, damping = stalled + 1, min(damping * INCREASE, 1e12)
            losses.append(loss)
            if followed:
                problem.look(iteration + 1, parameters)
            if stalled == 20 or loss == 0 or problem.out_of_time:
                break
            progress((iteration + 1) / self.iterations, f"iteration {iteration + 1}, loss {loss:.2e}")
        return parameters, losses, "ok"


Options = LevenbergMarquardt


def damped_step(gram: np.ndarray, gradient: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """The step -(J'J + diag(damping))^-1 J'r from gram J'J and gradient J'r; 0 where the matrix is not definite."""
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    damped = gram + np.diag(damping + 1e-8 * damping.mean())
    try:
        # scaled to a unit diagonal, so that weights of very different sizes do not spoil the factorisation
        scale = 1 / np.sqrt(damped.diagonal())
        step: np.ndarray = -scale * cho_solve(cho_factor(damped * np.outer(scale, scale)), scale * gradient)
        return step
    except LinAlgError:
        return np.zeros_like(gradient)  # gains nothing, so the damping rises
