"""The simulator as C: written around the straight-line acceleration, compiled once, kept on disk."""

import ctypes
from collections.abc import Sequence

import numpy as np

from repro.codegen import straight_line
from repro.codegen.c_library import load_library
from repro.codegen.c_source import c_source
from repro.codegen.straight_line import INPUTS, OUTPUT
from repro.mechanics.substeps import SubstepRule


class CompiledIntegrator:
    """One compiled acceleration; see `simulate` for what the arguments mean."""

    def __init__(self, statements: Sequence[str], n_work: int, n_q: int, n_u: int) -> None:
        accelerate = straight_line.function("accelerate", INPUTS, OUTPUT, statements, n_work)
        sizes = f"#define N_Q {n_q}\n#define N_U {n_u}\n"
        source = f"{straight_line.preamble()}\n{sizes}{accelerate}{c_source(__file__, 'runge_kutta')}"
        self._simulate = load_library(source, straight_line.flags(statements)).simulate
        whole, real, array = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
        self._simulate.argtypes = [whole, whole, real, array, array, whole, array, whole, real, real, real, array]
        self._simulate.restype = None

    def __call__(self, rule: SubstepRule, u: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
        """Fill states[:, 1:] from states[:, 0]; every array is contiguous."""
        angles = np.array(rule.angles, dtype=np.int64)
        self._simulate(
            *u.shape[:2],
            rule.time_step,
            u.ctypes.data,
            parameters.ctypes.data,
            parameters.shape[1] if len(parameters) > 1 else 0,
            angles.ctypes.data,
            len(angles),
            rule.least,
            rule.most,
            rule.per_rate,
            states.ctypes.data,
        )
