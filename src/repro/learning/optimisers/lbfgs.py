"""L-BFGS (SciPy's)."""

from dataclasses import dataclass

import numpy as np

from repro.learning.full_batch import FullBatch, Solution
from repro.learning.members import MemberProblem
from repro.learning.result import Progress
from repro.plugins.options import Count

NOT_FINITE = 1e30  # loss for the line search where the model is singular


@dataclass(frozen=True)
class LBFGS(FullBatch):
    """Limited-memory BFGS with `memory` pairs (Liu and Nocedal 1989) on a full batch of `samples` per member."""

    iterations: Count = 1000
    samples: Count | None = 6000
    memory: Count = 30

    def solve(self, problem: MemberProblem, start: np.ndarray, progress: Progress) -> Solution:
        """Minimise from the weights `start` (n_parameters,)."""
        from scipy.optimize import OptimizeResult, minimize

        def value_and_gradient(x: np.ndarray) -> tuple[float, np.ndarray]:
            loss, gradient = problem.loss_and_gradient(x)
            if not np.isfinite(loss) or not np.isfinite(gradient).all():
                return NOT_FINITE, np.zeros_like(x)
            return loss, gradient

        problem.look(0, start)
        losses = [value_and_gradient(start)[0]]
        if losses[0] == NOT_FINITE:
            return start, [float("nan")], "diverged at step 0"

        def note(intermediate_result: OptimizeResult) -> None:
            losses.append(float(intermediate_result.fun))
            problem.look(len(losses) - 1, intermediate_result.x)
            if problem.out_of_time:
                raise StopIteration  # which SciPy takes as the end
            progress(min(len(losses) / self.iterations, 1.0), f"iteration {len(losses)}, loss {losses[-1]:.2e}")

        limits = {"maxiter": self.iterations, "maxfun": 3 * self.iterations, "maxcor": self.memory}
        limits |= {"ftol": 0, "gtol": 0}
        found = minimize(value_and_gradient, start, jac=True, method="L-BFGS-B", callback=note, options=limits)
        return found.x, losses, "ok"


Options = LBFGS
