"""L-BFGS (SciPy's), full batch, float64, one member after another."""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from repro.learning.levenberg_marquardt import merge_curves
from repro.learning.members import MemberProblem
from repro.learning.optimiser import Optimiser
from repro.learning.problem import Problem
from repro.learning.result import Checkpoint, Fitted, Progress

NOT_FINITE = 1e30  # what the line search is told where the model is singular


@dataclass(frozen=True)
class LBFGS(Optimiser):
    """Limited-memory BFGS with `memory` pairs (Liu and Nocedal 1989) on a full batch of `samples` a member."""

    iterations: int = 1000
    samples: int | None = 6000
    memory: int = 30

    def fit(self, problem: Problem, parameters: Tensor, progress: Progress, checkpoint: Checkpoint) -> Fitted:
        """Train from `parameters` (member, n_parameters); the result is float64."""
        reduced = problem.subsample(self.samples)
        state = checkpoint.load() or {"done": []}
        for member in range(len(state["done"]), problem.members):
            share = (member / problem.members, 1 / problem.members)
            start = parameters[member].double().numpy()
            state["done"].append(self._one(MemberProblem(reduced.member(member)), start, progress, share))
            checkpoint.save(state)
        weights, curves, status = zip(*state["done"], strict=True)
        fitted = torch.from_numpy(np.stack(weights))
        return Fitted(fitted, merge_curves(curves), list(status), {"epochs": self.iterations})

    def _one(
        self, problem: MemberProblem, start: np.ndarray, progress: Progress, share: tuple[float, float]
    ) -> tuple[np.ndarray, list[float], str]:
        from scipy.optimize import OptimizeResult, minimize

        def value_and_gradient(x: np.ndarray) -> tuple[float, np.ndarray]:
            loss, gradient = problem.loss_and_gradient(x)
            if not np.isfinite(loss) or not np.isfinite(gradient).all():
                return NOT_FINITE, np.zeros_like(x)
            return loss, gradient

        losses = [value_and_gradient(start)[0]]
        if losses[0] == NOT_FINITE:
            return start, [float("nan")], "diverged at step 0"

        def note(intermediate_result: OptimizeResult) -> None:
            losses.append(float(intermediate_result.fun))
            done = share[0] + share[1] * len(losses) / self.iterations
            progress(min(done, 1.0), f"iteration {len(losses)}, loss {losses[-1]:.2e}")

        limits = {"maxiter": self.iterations, "maxfun": 3 * self.iterations, "maxcor": self.memory}
        found = minimize(
            value_and_gradient,
            start,
            jac=True,
            method="L-BFGS-B",
            callback=note,
            options=limits | {"ftol": 0, "gtol": 0},
        )
        return found.x, losses, "ok"
