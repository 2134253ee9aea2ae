"""Solvers of problem (9): IPOPT (Waechter & Biegler 2006), and fatrop (Vanroye et al. 2023), which uses the stages."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from repro.codegen.c_library import has_compiler, library_file
from repro.control.nonlinear_solver import CompiledProgramme, NonlinearSolver, Solver
from repro.control.optimal_control_problem import SolverName
from repro.control.programme import Programme, programme
from repro.control.shooting import shooting_code
from repro.control.solver_process import GuardedSolver
from repro.control.transcription import Transcription

FLAGS = ("-O1",)
VECTOR_FLAGS = ("-O2", "-march=native")
# the functions of a library for fatrop, with their outputs
LIBRARY = {
    "nlp": ("f", "g"),
    "nlp_f": ("f",),
    "nlp_g": ("g",),
    "nlp_grad_f": ("grad_f_x",),
    "nlp_jac_g": ("g", "jac_g_x"),
    "nlp_hess_l": ("grad_gamma_x", "hess_gamma_x_x"),
    "nlp_grad": ("f", "g", "grad_gamma_x", "grad_gamma_p"),
}
START_BARRIER = 0.1  # fatrop's mu_init
_QUIET = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False, "calc_lam_p": False}


@dataclass(frozen=True)
class Limits:
    """Limits of one solution: tolerance, iterations, and CPU time in s."""

    tolerance: float = 1e-4
    iterations: int = 40
    seconds: float = 2.0


def make_solver(of: Transcription, name: SolverName, limits: Limits) -> Solver:
    """The solver of a transcription; without a C compiler IPOPT stands in for fatrop, which needs compiled code."""
    if name == "fatrop" and has_compiler():
        return GuardedSolver(compiled_programme(of, limits), limits.seconds)
    return ipopt(of, limits)


def ipopt(of: Transcription, limits: Limits) -> NonlinearSolver:
    """IPOPT with exact derivatives, evaluated by CasADi."""
    nlp = programme(of)
    derivatives = {
        "grad_f": nlp.function("grad_f", ["f", "grad_f_x"]),
        "jac_g": nlp.function("jac_g", ["g", "jac_g_x"]),
        "hess_lag": nlp.function("hess_lag", ["triu_hess_gamma_x_x"]),
    }
    options: Mapping[str, Any] = {
        "print_level": 0,
        "sb": "yes",
        "tol": limits.tolerance,
        "max_iter": limits.iterations,
        "max_cpu_time": limits.seconds,
    }
    expressions = {"x": nlp.inputs["x"], "p": nlp.inputs["p"], "f": nlp.outputs["f"], "g": nlp.outputs["g"]}
    function = ca.nlpsol("solver", "ipopt", expressions, {**_QUIET, **derivatives, "ipopt": options})
    return NonlinearSolver(function, of.bounds())


def compiled_programme(of: Transcription, limits: Limits) -> CompiledProgramme:
    """The programme as machine code for fatrop; CompilerError without a C compiler."""
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
    by_lanes = of.discretisation == "shooting" and not of.model.is_wide
    source, flags = (shooting_code(of), VECTOR_FLAGS) if by_lanes else (_code(programme(of)), FLAGS)
    return CompiledProgramme(str(library_file(source, flags)), options, bounds)


def _code(of: Programme) -> str:
    """C source with the functions that fatrop looks up in a library."""
    generator = ca.CodeGenerator("programme.c")
    for name, outputs in LIBRARY.items():
        generator.add(of.function(name, outputs))
    return str(generator.dump())
