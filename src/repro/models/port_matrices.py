"""The matrices of eq. (5) that are learned: J = A - A', eq. (10), and R = L L', eq. (11)."""

from collections.abc import Sequence

import casadi
import numpy as np

from repro.models.model_options import NonNegative
from repro.models.network import Network, softplus


class Skew:
    """J(x) = D (A(x) - A(x)') D, D = diag(scale): a network for the entries of A below its diagonal."""

    def __init__(self, n_in: int, hidden: Sequence[int], scale: np.ndarray) -> None:
        n = len(scale)
        self.scale, self.network = casadi.diag(casadi.DM(scale)), Network(n_in, tuple(hidden), n * (n - 1) // 2, "tanh")
        self.n_parameters = self.network.n_parameters
        self.initial = self.network.initial  # nothing of the canonical J is given

    def matrix(self, z: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """J at the network's inputs z."""
        lower = _strictly_lower(self.network.expression(parameters, z), self.scale.shape[0])
        return self.scale @ (lower - lower.T) @ self.scale


class Factored:
    """R = D L L' D, D = diag(scale), for a lower triangular L whose diagonal is non-negative by `non_negative`.

    Two networks, one for the entries below the diagonal and one for the diagonal; constants where `hidden` is None.
    """

    def __init__(
        self, n_in: int, hidden: Sequence[int] | None, scale: np.ndarray, non_negative: NonNegative = "softplus"
    ) -> None:
        n, self.constant, self.non_negative = len(scale), hidden is None, non_negative
        n_in = 0 if hidden is None else n_in  # without inputs, a network is its output's bias
        sizes = n * (n - 1) // 2, n
        self.scale = casadi.diag(casadi.DM(scale))
        self.below, self.diagonal = (Network(n_in, tuple(hidden or ()), size, "tanh") for size in sizes)
        self.n_parameters = self.below.n_parameters + self.diagonal.n_parameters

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights, zero biases."""
        return np.concatenate([self.below.initial(generators), self.diagonal.initial(generators)], axis=1)

    def matrix(self, z: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """R at the networks' inputs z."""
        inputs = casadi.SX(0, 1) if self.constant else z
        split = self.below.n_parameters
        below = self.below.expression(parameters[:split], inputs)
        diagonal = self.diagonal.expression(parameters[split:], inputs)
        diagonal = softplus(diagonal) if self.non_negative == "softplus" else casadi.fmax(diagonal, 0)
        scaled = self.scale @ (_strictly_lower(below, self.scale.shape[0]) + casadi.diag(diagonal))
        return scaled @ scaled.T


def _strictly_lower(entries: casadi.SX, n: int) -> casadi.SX:
    matrix = casadi.SX.zeros(n, n)
    rows, columns = np.tril_indices(n, -1)
    for number, (row, column) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
        matrix[row, column] = entries[number]
    return matrix
