"""Fixed-step simulation under inputs that are held over each step.

Generated C integrates where a compiler is there, CasADi's virtual machine otherwise; both do the same
operations in the same order.
"""

import logging
from collections.abc import Callable, Sequence
from functools import lru_cache

import casadi as ca
import numpy as np

from repro.codegen.c_library import CompilerError, has_compiler
from repro.codegen.straight_line import statements
from repro.errors import UserError
from repro.mechanics.integrators import CompiledIntegrator, InterpretedIntegrator, SubstepRule

ENGINES = ("auto", "cheaper", "c", "casadi")
# Seconds of a compiler, and of its absence: measured with the models of this project.
COMPILATION_S, COMPILED_INSTRUCTION_S = 0.08, 1.2e-4
STEP_S, INSTRUCTION_S = 1e-5, 3e-9
# Takes a rule, u (batch, steps, n_u) and parameters (1 or batch, n_p), and fills states (batch, steps + 1, 2 n_q).
Integrator = Callable[[SubstepRule, np.ndarray, np.ndarray, np.ndarray], None]


@lru_cache(maxsize=1)
def active_engine() -> str:
    """Return what engine="auto" means on this machine: "c", or "casadi" where nothing compiles C."""
    try:
        CompiledIntegrator(["qdd[0] = u[0]"], 0, 1, 1)
    except (CompilerError, OSError) as error:
        if has_compiler():
            logging.getLogger("repro").warning("simulating with CasADi, more slowly: %s", error)
        return "casadi"
    return "c"


class CheaperIntegrator:
    """Interprets one acceleration until that has taken about as long as a compiler does; compiled from then on."""

    def __init__(self, acceleration: ca.Function) -> None:
        self._acceleration = acceleration
        self._size = acceleration.n_instructions()
        self._left_s = COMPILATION_S + self._size * COMPILED_INSTRUCTION_S

    def __call__(self, rule: SubstepRule, u: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]."""
        evaluations = 4 * rule.least
        self._left_s -= len(u) * u.shape[1] * (STEP_S + evaluations * self._size * INSTRUCTION_S)
        compiled(self._acceleration, "casadi" if self._left_s > 0 else "auto")(rule, u, parameters, states)


@lru_cache(maxsize=64)
def compiled(acceleration: ca.Function, engine: str = "auto") -> Integrator:
    """Compile acceleration(q, qd, u, parameters) for an engine; UserError for one that is unknown or not there."""
    if engine not in ENGINES:
        raise UserError(f"unknown engine {engine!r}: choose one of {', '.join(ENGINES)}")
    if engine == "cheaper":
        return CheaperIntegrator(acceleration)
    if (active_engine() if engine == "auto" else engine) == "casadi":
        return InterpretedIntegrator(acceleration)
    try:
        return CompiledIntegrator(*statements(acceleration), acceleration.numel_out(0), acceleration.numel_in(2))
    except CompilerError as error:
        raise UserError(f"engine 'c' cannot be used ({error}): choose 'casadi' or 'auto'") from error


def simulate(
    acceleration: ca.Function,
    initial: np.ndarray,
    u: np.ndarray,
    time_step: float,
    *,
    substeps: int | None = None,
    angles: Sequence[int] | None = None,
    parameters: np.ndarray | None = None,
    engine: str = "auto",
) -> np.ndarray:
    """Integrate qdd = acceleration(q, qd, u, parameters) by classical RK4, u held over each step of time_step s.

    initial: (batch, 2 n_q) = [q, qd]; u: (batch, steps, n_u), inputs or generalised forces; parameters: (n_p,), or
    (batch, n_p) for one set each.
    Returns states (batch, steps + 1, 2 n_q); row k is the state at the start of step k.
    Without `substeps` each step has as many as the speed of `angles` (positions of coordinates; all by default) needs,
    see `SubstepRule`. A trajectory that is no longer finite, or too fast to be followed, is NaN from there on.
    ValueError for shapes that do not fit, UserError for an engine that is unknown or not there.
    """
    n_q, n_u = acceleration.numel_out(0), acceleration.numel_in(2)
    initial, u = np.asarray(initial, dtype=float), np.ascontiguousarray(u, dtype=float)
    if u.ndim != 3 or initial.shape != (len(u), 2 * n_q) or u.shape[2] != n_u:
        raise ValueError(f"initial (batch, {2 * n_q}) and u (batch, steps, {n_u}) got {initial.shape}, {u.shape}")
    weights = np.ascontiguousarray(np.atleast_2d(np.zeros(0) if parameters is None else parameters), dtype=float)
    if weights.shape[1] != acceleration.numel_in(3) or len(weights) not in {1, len(u)}:
        raise ValueError(f"parameters ({acceleration.numel_in(3)},), one set or one a trajectory, got {weights.shape}")
    if substeps is not None and substeps < 1:
        raise ValueError(f"substeps must be at least 1, got {substeps}")
    states = np.empty((len(u), u.shape[1] + 1, 2 * n_q))
    states[:, 0] = initial
    everywhere = range(n_q) if angles is None else angles
    rule = SubstepRule.for_angles(time_step, everywhere)
    if substeps is not None:
        rule = SubstepRule(time_step, (), substeps, substeps, 0.0)
    compiled(acceleration, engine)(rule, u, weights, states)
    return states
