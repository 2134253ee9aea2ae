"""A member's energies as a torch module of straight-line code, made from the same expressions as everything else."""

from pathlib import Path

import casadi
import numpy as np

from repro.codegen.straight_line import statements
from repro.models.model import Model

HEAD = '''"""{title}: needs torch and numpy alone.

q, qd, qdd, tau are float64 tensors (..., {n_q}) with any leading axes; energies are in J.
"""

from pathlib import Path

import numpy as np
import torch

PARAMETERS = torch.from_numpy(np.load(Path(__file__).with_name("weights.npz"))["parameters"])


def _of_tensors(function):
    return lambda *values: function(*(torch.as_tensor(value, dtype=torch.float64) for value in values))


def _of_numbers(function):
    return _of_tensors(lambda *values: function(*values).to(torch.float64))


exp, expm1, log, log1p, sqrt = map(_of_tensors, (torch.exp, torch.expm1, torch.log, torch.log1p, torch.sqrt))
sin, cos, tan, atan, atan2 = map(_of_tensors, (torch.sin, torch.cos, torch.tan, torch.atan, torch.atan2))
tanh, sinh, cosh, fabs, sign = map(_of_tensors, (torch.tanh, torch.sinh, torch.cosh, torch.abs, torch.sign))
fmax, fmin, pow = map(_of_tensors, (torch.fmax, torch.fmin, torch.pow))
less, less_equal, equal, unequal = map(_of_numbers, (torch.lt, torch.le, torch.eq, torch.ne))
both, either, negation = map(_of_numbers, (torch.logical_and, torch.logical_or, torch.logical_not))
if_else_zero = _of_tensors(lambda condition, value: torch.where(condition != 0, value, 0.0))

'''
ENERGIES = '''
def _all(q, qd):
    value = [None] * (2 + q.shape[-1])
    _energies_and_friction(q.unbind(-1), qd.unbind(-1), PARAMETERS.unbind(0), value)
    return [part + 0 * q[..., 0] for part in value]


def energies(q, qd):
    """T and V, each (...)."""
    return tuple(_all(q, qd)[:2])


def friction(q, qd):
    """Friction, the forces that do not follow from L."""
    return torch.stack(_all(q, qd)[2:], dim=-1)


def lagrangian(q, qd):
    """L = T - V."""
    kinetic, potential = energies(q, qd)
    return kinetic - potential


def momentum(q, qd):
    """p = dL/dqd."""
    return torch.func.grad(lambda rates: lagrangian(q, rates).sum())(qd)


def hamiltonian(q, qd):
    """H = p . qd - L."""
    return (momentum(q, qd) * qd).sum(-1) - lagrangian(q, qd)


def mass_matrix(q, qd):
    """M = dp/dqd, (..., n_q, n_q)."""
    axes = torch.eye(q.shape[-1], dtype=q.dtype)
    columns = [torch.func.jvp(lambda rates: momentum(q, rates), (qd,), (axis.expand_as(qd),))[1] for axis in axes]
    return torch.stack(columns, dim=-1)


def inverse(q, qd, qdd):
    """tau = d/dt(dL/dqd) - dL/dq + friction."""
    rate = torch.func.jvp(momentum, (q, qd), (qd, qdd))[1]
    return rate - torch.func.grad(lambda place: lagrangian(place, qd).sum())(q) + friction(q, qd)


def forward(q, qd, tau):
    """qdd, where M is not singular."""
    push = tau - inverse(q, qd, torch.zeros_like(qd))
    return torch.linalg.solve(mass_matrix(q, qd), push.unsqueeze(-1)).squeeze(-1)
'''
FORWARD = '''
def forward(q, qd, tau):
    """qdd."""
    value = [None] * q.shape[-1]
    _forward(q.unbind(-1), qd.unbind(-1), tau.unbind(-1), PARAMETERS.unbind(0), value)
    return torch.stack(value, dim=-1)
'''


def write(folder: Path, model: Model, weights: np.ndarray, title: str) -> list[str]:
    """Write model.py and weights.npz; return their names."""
    np.savez(folder / "weights.npz", parameters=weights)
    q, qd, tau = (casadi.SX.sym(name, model.n_q) for name in ("q", "qd", "tau"))
    parameters = casadi.SX.sym("parameters", len(weights))
    if model.energetic:
        energies = model.energies(q, qd, parameters)
        outputs = casadi.vertcat(energies.kinetic, energies.potential, model.friction(q, qd, parameters))
        body = _code("_energies_and_friction", {"q": q, "qd": qd, "parameters": parameters}, outputs) + ENERGIES
    else:
        inputs = {"q": q, "qd": qd, "tau": tau, "parameters": parameters}
        body = _code("_forward", inputs, model.acceleration(q, qd, tau, parameters)) + FORWARD
    (folder / "model.py").write_text(HEAD.format(title=title, n_q=model.n_q) + body)
    return ["model.py", "weights.npz"]


def _code(name: str, inputs: dict[str, casadi.SX], expression: casadi.SX) -> str:
    function = casadi.Function(name[1:], [*inputs.values()], [casadi.densify(expression)], {"cse": True})
    lines, size = statements(function, tuple(inputs), "value")
    head = [f"def {name}({', '.join(inputs)}, value):", f"    w = [None] * {size}"]
    return "\n".join([*head, *(f"    {line}" for line in lines)]) + "\n"
