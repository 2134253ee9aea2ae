"""Solvers of nonlinear programmes and their solutions; imports little, so that a child process starts quickly."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca
import numpy as np

OUT_OF_TIME = ("killed", "Maximum_CpuTime_Exceeded")  # the status from GuardedSolver, from IPOPT


@dataclass(frozen=True)
class Solution:
    """The result of one solution."""

    variables: np.ndarray  # decision variables (n_variables,); nan without a result
    converged: bool  # whether the solver reports success
    violation: float  # the largest violation of any constraint; infinite without a result
    iterations: int
    status: str  # the solver's return status
    objective: float
    seconds: float = 0.0  # CPU time

    @property
    def out_of_time(self) -> bool:
        """Whether it exceeded its CPU time."""
        return self.status in OUT_OF_TIME


class Solver(Protocol):
    """Solves one nonlinear programme."""

    def __call__(self, parameters: np.ndarray, guess: np.ndarray) -> Solution:
        """The solution for parameters (n_parameters,) from a guess of the variables (n_variables,)."""

    def close(self) -> None:
        """Free the resources of the solver, where it has any."""
        return


@dataclass(frozen=True)
class NonlinearSolver(Solver):
    """A CasADi solver with the bounds lbx, ubx, lbg, ubg of its programme."""

    function: ca.Function
    bounds: Mapping[str, np.ndarray]

    def __call__(self, parameters: np.ndarray, guess: np.ndarray) -> Solution:
        """Solve, and measure the violation of the constraints."""
        started = time.thread_time()
        result = self.function(x0=guess, p=parameters, **self.bounds)
        statistics = self.function.stats()
        variables, constraints = (np.asarray(result[name]).ravel() for name in ("x", "g"))
        outside = np.maximum(self.bounds["lbg"] - constraints, constraints - self.bounds["ubg"])
        violation = float(np.max(outside, initial=0.0))
        return Solution(
            variables=variables,
            converged=bool(statistics["success"]),
            violation=violation if np.all(np.isfinite(variables)) and np.isfinite(violation) else np.inf,
            iterations=int(statistics["iter_count"]),
            status=str(statistics["return_status"]),
            objective=float(result["f"]),
            seconds=time.thread_time() - started,
        )


@dataclass(frozen=True)
class CompiledProgramme:
    """All that fatrop needs to start in any process: a library with the functions of a programme, options, bounds."""

    library: str
    options: Mapping[str, Any]
    bounds: Mapping[str, np.ndarray]

    def start(self) -> NonlinearSolver:
        """A solver in this process."""
        return NonlinearSolver(ca.nlpsol("solver", "fatrop", self.library, dict(self.options)), self.bounds)
