"""A member's functions with its weights inside, as CasADi files and C source."""

from collections.abc import Sequence
from pathlib import Path

import casadi
import numpy as np

from repro.mechanics.derive import derive
from repro.models.model import Model

SOURCE = "model.c"


def functions(model: Model, weights: np.ndarray) -> list[casadi.Function]:
    """Functions of columns q, qd, qdd or tau (n_q,): those of a Lagrangian, or the forward dynamics alone."""
    q, qd, qdd, tau = (casadi.SX.sym(name, model.n_q) for name in ("q", "qd", "qdd", "tau"))
    fixed = casadi.SX(casadi.DM(weights))
    if not model.energetic:
        return [_function("forward", {"q": q, "qd": qd, "tau": tau}, "qdd", model.acceleration(q, qd, tau, fixed))]
    energies = model.energies(q, qd, fixed)
    dynamics = derive(energies.kinetic, energies.potential, casadi.SX(0), q, qd)
    none, state = casadi.SX(0, 1), {"q": q, "qd": qd}
    return [
        _function("kinetic", state, "T", dynamics.kinetic(q, qd, none)),
        _function("potential", state, "V", dynamics.potential(q, qd, none)),
        _function("lagrangian", state, "L", dynamics.lagrangian(q, qd, none)),
        _function("hamiltonian", state, "H", dynamics.hamiltonian(q, qd, none)),
        _function("momentum", state, "p", dynamics.momentum(q, qd, none)),
        _function("mass_matrix", state, "M", dynamics.mass_matrix(q, qd, none)),
        _function("inverse", state | {"qdd": qdd}, "tau", model.inverse_dynamics(q, qd, qdd, fixed)),
        _function("forward", state | {"tau": tau}, "qdd", model.acceleration(q, qd, tau, fixed)),
    ]


def write(folder: Path, written: Sequence[casadi.Function]) -> list[str]:
    """Write each function to a file of its name, and all of them to C; return the names of the files."""
    generator = casadi.CodeGenerator(SOURCE, {"with_header": True})
    for function in written:
        function.save(str(folder / f"{function.name()}.casadi"))
        generator.add(function)
    generator.generate(f"{folder}/")
    return [*(f"{function.name()}.casadi" for function in written), SOURCE, "model.h"]


def _function(name: str, inputs: dict[str, casadi.SX], output: str, expression: casadi.SX) -> casadi.Function:
    return casadi.Function(name, [*inputs.values()], [casadi.densify(expression)], [*inputs], [output], {"cse": True})
