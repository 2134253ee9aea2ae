"""A nonlinear programme's solver at work: light enough for a process of its own."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca
import numpy as np

OUT_OF_TIME = ("killed", "Maximum_CpuTime_Exceeded")  # by the guard of a process, by IPOPT


@dataclass(frozen=True)
class Solution:
    """What a solver leaves: the decision variables, whether it converged, and how it got there.

    violation: the largest of any constraint; infinite where there are no variables. seconds: of CPU time.
    """

    variables: np.ndarray
    converged: bool
    violation: float
    iterations: int
    status: str
    objective: float
    seconds: float = 0.0

    @property
    def out_of_time(self) -> bool:
        """Whether it took more CPU time than it may."""
        return self.status in OUT_OF_TIME


class Solver(Protocol):
    """Solves one programme from a guess of its variables."""

    def __call__(self, parameters: np.ndarray, guess: np.ndarray) -> Solution:
        """The solution for these parameters."""

    def close(self) -> None:
        """Let go of what the solver holds."""


@dataclass(frozen=True)
class NonlinearSolver:
    """A CasADi solver with the bounds lbx, ubx, lbg, ubg of its programme."""

    function: ca.Function
    bounds: Mapping[str, np.ndarray]

    def __call__(self, parameters: np.ndarray, guess: np.ndarray) -> Solution:
        """Solve, and say how well the constraints hold."""
        found = self.function(x0=guess, p=parameters, **self.bounds)
        told = self.function.stats()
        variables, constraints = (np.asarray(found[name]).ravel() for name in ("x", "g"))
        outside = np.maximum(self.bounds["lbg"] - constraints, constraints - self.bounds["ubg"])
        violation = float(np.max(outside, initial=0.0))
        return Solution(
            variables=variables,
            converged=bool(told["success"]),
            violation=violation if np.all(np.isfinite(variables)) and np.isfinite(violation) else np.inf,
            iterations=int(told["iter_count"]),
            status=str(told["return_status"]),
            objective=float(found["f"]),
        )


@dataclass(frozen=True)
class CompiledProgramme:
    """What fatrop needs to start anywhere: a library with the functions of a programme, options and bounds."""

    library: str
    options: Mapping[str, Any]
    bounds: Mapping[str, np.ndarray]

    def start(self) -> NonlinearSolver:
        """A solver in this process."""
        return NonlinearSolver(ca.nlpsol("solver", "fatrop", self.library, dict(self.options)), self.bounds)
