"""Which engine integrates: generated C where a compiler is there, CasADi's virtual machine otherwise."""

import logging
from functools import lru_cache
from typing import Protocol

import casadi as ca
import numpy as np

from repro.codegen.c_library import CompilerError, has_compiler
from repro.codegen.straight_line import statements
from repro.errors import UserError
from repro.mechanics import c_engine
from repro.mechanics.casadi_engine import InterpretedIntegrator
from repro.mechanics.substeps import SubstepRule

ENGINES = ("auto", "c", "casadi")


class Integrator(Protocol):
    """A compiled acceleration that fills states (batch, steps + 1, 2 n_q) from states[:, 0]."""

    def __call__(self, rule: SubstepRule, u: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Integrate with these sub-steps; u (batch, steps, n_u), parameters (1 or batch, n_p)."""


@lru_cache(maxsize=1)
def active_engine() -> str:
    """Return what engine="auto" means on this machine: "c", or "casadi" where nothing compiles C."""
    try:
        c_engine.CompiledIntegrator(["qdd[0] = u[0]"], 0, 1, 1)
    except (CompilerError, OSError) as error:
        if has_compiler():
            logging.getLogger("repro").warning("simulating with CasADi, more slowly: %s", error)
        return "casadi"
    return "c"


@lru_cache(maxsize=64)
def compiled(acceleration: ca.Function, engine: str = "auto") -> Integrator:
    """Compile acceleration(q, qd, u, parameters) for an engine; UserError for one that is unknown or not there."""
    if engine not in ENGINES:
        raise UserError(f"unknown engine {engine!r}: choose one of {', '.join(ENGINES)}")
    if (active_engine() if engine == "auto" else engine) == "casadi":
        return InterpretedIntegrator(acceleration)
    try:
        return c_engine.CompiledIntegrator(
            *statements(acceleration), acceleration.numel_out(0), acceleration.numel_in(2)
        )
    except CompilerError as error:
        raise UserError(f"engine 'c' cannot be used ({error}): choose 'casadi' or 'auto'") from error
