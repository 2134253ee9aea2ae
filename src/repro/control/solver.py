"""Solvers of problem (9): IPOPT as the reference, fatrop (which knows the stages) as the fast path."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import casadi as ca
import numpy as np

from repro.codegen.c_library import has_compiler, library_file
from repro.control.matrix_network import is_wide
from repro.control.nonlinear import CompiledProgramme, NonlinearSolver, Solution, Solver
from repro.control.programme import Programme, programme
from repro.control.shooting import shooting_code
from repro.control.solver_process import GuardedSolver
from repro.control.transcription import Transcription

SolverName = Literal["fatrop", "ipopt"]
FLAGS = ("-O1",)
VECTOR_FLAGS = ("-O2", "-march=native")
START_BARRIER = 0.1  # fatrop's mu_init
_QUIET = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False, "calc_lam_p": False}


@dataclass(frozen=True)
class Limits:
    """When a solver stops: the tolerance that it reaches, iterations, and seconds of CPU time."""

    tolerance: float = 1e-4
    iterations: int = 40
    seconds: float = 2.0


def make_solver(of: Transcription, name: SolverName, limits: Limits) -> Solver:
    """The solver of a transcription; without a C compiler IPOPT stands in for fatrop, whose code it would compile."""
    if name == "fatrop" and has_compiler():
        return GuardedSolver(compiled_programme(of, limits), limits.seconds)
    return Timed(ipopt(of, limits))


@dataclass(frozen=True)
class Timed:
    """A solver in this process, with the CPU time of every solution."""

    solver: NonlinearSolver

    def __call__(self, parameters: np.ndarray, guess: np.ndarray) -> Solution:
        """The solution."""
        started = time.thread_time()
        solution = self.solver(parameters, guess)
        return replace(solution, seconds=time.thread_time() - started)

    def close(self) -> None:
        """Nothing is held."""


def ipopt(of: Transcription, limits: Limits) -> NonlinearSolver:
    """IPOPT with exact derivatives, evaluated by CasADi."""
    made = programme(of)
    given, point = [made.x, made.p], ["x", "p"]
    derivatives = {
        "grad_f": ca.Function("grad_f", given, [made.f, made.grad_f], point, ["f", "grad_f_x"]),
        "jac_g": ca.Function("jac_g", given, [made.g, made.jac_g], point, ["g", "jac_g_x"]),
        "hess_lag": ca.Function(
            "hess_lag",
            [*given, made.lam_f, made.lam_g],
            [ca.triu(made.hess_l)],
            [*point, "lam_f", "lam_g"],
            ["triu_hess_gamma_x_x"],
        ),
    }
    options: Mapping[str, Any] = {
        "print_level": 0,
        "sb": "yes",
        "tol": limits.tolerance,
        "max_iter": limits.iterations,
        "max_cpu_time": limits.seconds,
    }
    described = {"x": made.x, "p": made.p, "f": made.f, "g": made.g}
    function = ca.nlpsol("solver", "ipopt", described, {**_QUIET, **derivatives, "ipopt": options})
    return NonlinearSolver(function, of.bounds())


def compiled_programme(of: Transcription, limits: Limits) -> CompiledProgramme:
    """The programme as machine code for fatrop; CompilerError where nothing compiles C."""
    bounds = of.bounds()
    options = {
        **_QUIET,
        "structure_detection": "manual",
        "N": of.n_intervals,
        "nx": [of.n_x] * (of.n_intervals + 1),
        "nu": [*[of.n_v] * of.n_intervals, 0],
        "ng": [*(rows - of.n_x for rows in of.rows[:-1]), of.rows[-1]],
        "equality": (bounds["lbg"] == bounds["ubg"]).tolist(),
        "fatrop": {
            "print_level": 0,
            "tol": limits.tolerance,
            "mu_init": START_BARRIER,
            "max_iter": limits.iterations,
        },
    }
    by_lanes = of.discretisation == "shooting" and not is_wide(of.model.model)
    source, flags = (shooting_code(of), VECTOR_FLAGS) if by_lanes else (_code(programme(of)), FLAGS)
    return CompiledProgramme(str(library_file(source, flags)), options, bounds)


def _code(of: Programme) -> str:
    """C source with the functions that fatrop looks for in a library."""
    point, all_given = [of.x, of.p], [of.x, of.p, of.lam_f, of.lam_g]
    names, all_names = ["x", "p"], ["x", "p", "lam_f", "lam_g"]
    nobody_asks = ca.MX.zeros(of.p.shape)
    wanted = [
        ca.Function("nlp", point, [of.f, of.g], names, ["f", "g"]),
        ca.Function("nlp_f", point, [of.f], names, ["f"]),
        ca.Function("nlp_g", point, [of.g], names, ["g"]),
        ca.Function("nlp_grad_f", point, [of.grad_f], names, ["grad_f_x"]),
        ca.Function("nlp_jac_g", point, [of.g, of.jac_g], names, ["g", "jac_g_x"]),
        ca.Function("nlp_hess_l", all_given, [of.grad_l, of.hess_l], all_names, ["grad_gamma_x", "hess_gamma_x_x"]),
        ca.Function(
            "nlp_grad",
            all_given,
            [of.f, of.g, of.grad_l, nobody_asks],
            all_names,
            ["f", "g", "grad_gamma_x", "grad_gamma_p"],
        ),
    ]
    generator = ca.CodeGenerator("programme.c")
    for function in wanted:
        generator.add(function)
    return str(generator.dump())
