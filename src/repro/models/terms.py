"""The quantities that a model, or the true system, predicts at a batch of samples."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch

Quantity = Any  # a Tensor (numpy array in evaluation), or None where the quantity is not defined


@dataclass(frozen=True)
class Terms:
    """Predictions at the measured (q, qd, qdd); None where a model does not define a quantity.

    tau, momentum, transformed_momentum, acceleration: (member, sample, n_q) in N or N m, kg m/s or kg m^2/s, m/s^2 or
    rad/s^2; kinetic, potential: (member, sample) in J; mass: (member, sample, n_q, n_q); port_error: of eq. (12b), in
    the rates of q and of p, (member, sample, 2 n_q). energy: H of a model without a Lagrangian, (member, sample) in J.
    implicit_error: of a model's own implicit equation, which is linear in its weights, (member, sample, n_q).
    """

    tau: Quantity = None
    momentum: Quantity = None
    kinetic: Quantity = None
    potential: Quantity = None
    mass: Quantity = None
    transformed_momentum: Quantity = None
    acceleration: Quantity = None
    port_error: Quantity = None
    energy: Quantity = None
    implicit_error: Quantity = None

    @property
    def lagrangian(self) -> Quantity:
        """L = T - V, (member, sample) in J."""
        return self.kinetic - self.potential

    @property
    def energy_sum(self) -> Quantity:
        """T + V, the paper's H_hat (III-A.1), (member, sample) in J."""
        return self.kinetic + self.potential

    def hamiltonian(self, qd: Quantity) -> Quantity:
        """The Legendre transform H = p . qd - L, (member, sample) in J."""
        return (self.momentum * qd).sum(-1) - self.lagrangian

    def acceleration_error(self, qdd: Tensor, tau: Tensor) -> Tensor:
        """qdd_hat - qdd = M_hat^-1 (tau - tau_hat), (member, sample, n_q); not finite where M_hat is singular."""
        if self.acceleration is not None:
            error: Tensor = self.acceleration - qdd
            return error
        return _solve(self.mass, tau - self.tau)


def stack_terms(stack: Quantity, n_q: int) -> Terms:
    """Terms from rows [tau | p | T | V | M, upper entries, where it is known] (member, sample, n_rows)."""
    upper = stack[..., 2 * n_q + 2 : 2 * n_q + 2 + n_q * (n_q + 1) // 2]
    return Terms(
        tau=stack[..., :n_q],
        momentum=stack[..., n_q : 2 * n_q],
        kinetic=stack[..., 2 * n_q],
        potential=stack[..., 2 * n_q + 1],
        mass=symmetric(upper, n_q) if upper.shape[-1] else None,
    )


def _solve(matrix: Tensor, right: Tensor) -> Tensor:
    if matrix.shape[-1] == 2:  # cofactors: a batched factorisation of 2 x 2 matrices is ten times slower
        (a, b), (c, d) = (row.unbind(-1) for row in matrix.unbind(-2))
        x, y = right.unbind(-1)
        return torch.stack([d * x - b * y, a * y - c * x], dim=-1) / (a * d - b * c).unsqueeze(-1)
    solution: Tensor = torch.linalg.solve_ex(matrix, right.unsqueeze(-1))[0]
    return solution.squeeze(-1)


def symmetric(entries: Quantity, n_q: int) -> Quantity:
    """Symmetric matrices (..., n_q, n_q) from their upper entries in row order (..., n_q (n_q + 1) / 2)."""
    library: Any = np if isinstance(entries, np.ndarray) else torch  # whose tensors, and indices, may lie on a device
    index = library.zeros((n_q, n_q), dtype=library.int64)
    rows, columns = np.triu_indices(n_q) if library is np else torch.triu_indices(n_q, n_q)
    index[rows, columns] = library.arange(len(rows))
    index[columns, rows] = library.arange(len(rows))
    return entries[..., index]


def least_eigenvalue(mass: np.ndarray) -> np.ndarray:
    """Of each member's matrices (member, sample, n_q, n_q), (member,); 0 where a matrix is not finite."""
    finite = np.isfinite(mass).all((2, 3), keepdims=True)
    least: np.ndarray = np.linalg.eigvalsh(np.where(finite, mass, 0.0)).min((1, 2))
    return least
