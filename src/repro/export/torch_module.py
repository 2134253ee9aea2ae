"""A member's energies as a torch module of straight-line code, made from the same expressions as everything else."""

from pathlib import Path

import casadi
import numpy as np

from repro.codegen.straight_line import statements
from repro.models.model import Model

TEMPLATES = Path(__file__).with_name("templates")


def write(folder: Path, model: Model, weights: np.ndarray, title: str) -> list[str]:
    """Write model.py and weights.npz; return their names."""
    np.savez(folder / "weights.npz", parameters=weights)
    q, qd, tau = (casadi.SX.sym(name, model.n_q) for name in ("q", "qd", "tau"))
    parameters = casadi.SX.sym("parameters", len(weights))
    if model.energetic:
        energies = model.energies(q, qd, parameters)
        outputs = casadi.vertcat(energies.kinetic, energies.potential, model.friction(q, qd, parameters))
        code, rest = _code("_energies_and_friction", {"q": q, "qd": qd, "parameters": parameters}, outputs), "energies"
    else:
        inputs = {"q": q, "qd": qd, "tau": tau, "parameters": parameters}
        code, rest = _code("_forward", inputs, model.acceleration(q, qd, tau, parameters)), "forward"
    head = (TEMPLATES / "head.py.txt").read_text().format(title=title, n_q=model.n_q)
    (folder / "model.py").write_text(head + code + (TEMPLATES / f"{rest}.py.txt").read_text())
    return ["model.py", "weights.npz"]


def _code(name: str, inputs: dict[str, casadi.SX], expression: casadi.SX) -> str:
    function = casadi.Function(name[1:], [*inputs.values()], [casadi.densify(expression)], {"cse": True})
    lines, size = statements(function, tuple(inputs), "value")
    head = [f"def {name}({', '.join(inputs)}, value):", f"    w = [None] * {size}"]
    return "\n".join([*head, *(f"    {line}" for line in lines)]) + "\n"
