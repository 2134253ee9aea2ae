"""The matrices of eq. (5) that are learned: J = A - A', eq. (10), and R = L L', eq. (11)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi
import numpy as np

from repro.models.model_options import NonNegative
from repro.models.network import Network, softplus


@dataclass(frozen=True)
class Skew:
    """J(x) = D (A(x) - A(x)') D, D = diag(scale): a network for the entries of A below its diagonal."""

    n_in: int
    hidden: tuple[int, ...]
    scale: tuple[float, ...]
    network: Network = field(init=False)

    def __post_init__(self) -> None:
        n = len(self.scale)
        object.__setattr__(self, "network", Network(self.n_in, self.hidden, n * (n - 1) // 2, "tanh"))

    @property
    def n_parameters(self) -> int:
        """Number of weights."""
        return self.network.n_parameters

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights, zero biases: nothing of the canonical J is known."""
        return self.network.initial(generators)

    def matrix(self, z: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """J at the network's inputs z."""
        lower = _strictly_lower(self.network.expression(parameters, z), len(self.scale))
        scale = casadi.diag(casadi.DM(self.scale))
        return scale @ (lower - lower.T) @ scale


@dataclass(frozen=True)
class Factored:
    """R = D L L' D, D = diag(scale), for a lower triangular L whose diagonal is non-negative by `non_negative`.

    Two networks, one for the entries below the diagonal and one for the diagonal; constants where `hidden` is None.
    """

    n_in: int
    hidden: tuple[int, ...] | None
    scale: tuple[float, ...]
    non_negative: NonNegative = "softplus"
    below: Network = field(init=False)
    diagonal: Network = field(init=False)

    def __post_init__(self) -> None:
        n, hidden = len(self.scale), self.hidden or ()
        n_in = 0 if self.hidden is None else self.n_in  # without inputs, a network is its output's bias
        object.__setattr__(self, "below", Network(n_in, hidden, n * (n - 1) // 2, "tanh"))
        object.__setattr__(self, "diagonal", Network(n_in, hidden, n, "tanh"))

    @property
    def n_parameters(self) -> int:
        """Number of weights."""
        return self.below.n_parameters + self.diagonal.n_parameters

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights, zero biases."""
        return np.concatenate([self.below.initial(generators), self.diagonal.initial(generators)], axis=1)

    def matrix(self, z: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """R at the networks' inputs z."""
        inputs = z if self.hidden is not None else casadi.SX(0, 1)
        split = self.below.n_parameters
        below = self.below.expression(parameters[:split], inputs)
        diagonal = self.diagonal.expression(parameters[split:], inputs)
        diagonal = softplus(diagonal) if self.non_negative == "softplus" else casadi.fmax(diagonal, 0)
        factor = _strictly_lower(below, len(self.scale)) + casadi.diag(diagonal)
        scaled = casadi.diag(casadi.DM(self.scale)) @ factor
        return scaled @ scaled.T


def _strictly_lower(entries: casadi.SX, n: int) -> casadi.SX:
    matrix = casadi.SX.zeros(n, n)
    rows, columns = np.tril_indices(n, -1)
    for number, (row, column) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
        matrix[row, column] = entries[number]
    return matrix
