"""Every operation that has a symbolic form has the value that torch gives it."""

import casadi
import numpy as np
import pytest
import torch
from torch import nn

from repro.models.module_graph import NotSymbolicError, symbolic

OPERATIONS = {
    **{name: getattr(torch, name) for name in ("cos", "sin", "tan", "tanh", "cosh", "sinh", "exp", "erf", "abs")},
    **{name: getattr(torch, name) for name in ("sigmoid", "relu", "square", "neg")},
    **{name: getattr(nn.functional, name) for name in ("softplus", "silu", "gelu")},
    "log": lambda x: torch.log(x**2 + 1),
    "log1p": lambda x: torch.log1p(x**2),
    "sqrt": lambda x: torch.sqrt(x**2 + 1),
    "softplus of a layer": nn.Softplus(beta=2.0),
    "gelu of a layer": nn.GELU(),
    "silu of a layer": nn.SiLU(),
    "arithmetic": lambda x: (2 * x - 1) / (x**2 + 3) + 1 / (x**2 + 1),
    "sum of an axis": lambda x: torch.stack([x, x**2], dim=-1).sum(-1),
    "matrix": lambda x: (torch.diag(x) @ torch.stack([x, 2 * x, 3 * x])).sum(dim=1),
    "shape": lambda x: x.unsqueeze(0).transpose(0, 1).reshape(-1).view(x.shape[0]),
    "join": lambda x: torch.cat([x[1:], x[:1]]) * torch.dot(x, x),
    "flatten": lambda x: torch.stack([x, 2 * x]).flatten()[: x.shape[0]],
}


class One(nn.Module):
    def __init__(self, operation):
        super().__init__()
        self.operation = operation

    def forward(self, q):
        return self.operation(q)


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_equals_torch(name):
    module = One(OPERATIONS[name])
    q = casadi.SX.sym("q", 3)
    value = symbolic(module, "forward", [q], {})
    function = casadi.Function("f", [q], [casadi.vertcat(*value.ravel())])
    for at in ([0.3, -1.2, 2.0], [-0.5, 0.0, 0.9]):
        expected = module(torch.tensor(at, dtype=torch.float64)).numpy()
        np.testing.assert_allclose(function(at).full().ravel(), expected, rtol=1e-12, atol=1e-14)


def test_an_operation_without_counterpart_is_named():
    with pytest.raises(NotSymbolicError, match="outer has no symbolic form"):
        symbolic(One(lambda x: torch.outer(x, x)), "forward", [casadi.SX.sym("q", 3)], {})
    with pytest.raises(NotSymbolicError, match="only the exact GELU"):
        symbolic(One(nn.GELU(approximate="tanh")), "forward", [casadi.SX.sym("q", 3)], {})
    with pytest.raises(NotSymbolicError, match="gelu"):
        symbolic(One(lambda x: nn.functional.gelu(x, approximate="tanh")), "forward", [casadi.SX.sym("q", 3)], {})
