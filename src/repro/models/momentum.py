"""The transformation from velocities to momenta as a network of its own: p_tran = M_hat(q) qd, eq. (8)."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.models.features import FeatureMap
from repro.models.network import Network
from repro.models.position import PositionFeatures
from repro.models.terms import symmetric


@dataclass(frozen=True)
class MomentumTransform:
    """M_hat(q): a network on the position features whose outputs are the entries of a symmetric matrix."""

    n_q: int
    hidden: tuple[int, ...]
    positions: PositionFeatures
    features: FeatureMap = field(init=False)
    network: Network = field(init=False)

    def __post_init__(self) -> None:
        features = FeatureMap(self.positions.inertia, self.n_q)
        object.__setattr__(self, "features", features)
        n_out = self.n_q * (self.n_q + 1) // 2
        object.__setattr__(self, "network", Network(len(features), self.hidden, n_out))

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Starting weights (member, n_parameters)."""
        return self.network.initial(generators)

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """The position features as one-row jets, (..., 1, n_features)."""
        return self.features.jets(q, qd, qdd)[..., :1, :]

    def expression(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """p_tran as a CasADi expression."""
        entries = self.network.expression(parameters, self.features.expression(q, qd))
        matrix = casadi.SX(self.n_q, self.n_q)
        for number, (row, column) in enumerate(self.features.mass_pairs):
            matrix[row, column] = matrix[column, row] = entries[number]
        return matrix @ qd

    def momentum(self, entries: Tensor, qd: Tensor) -> Tensor:
        """p_tran = M_hat qd, (member, sample, n_q), from the network's output (member, sample, 1, n_entries)."""
        return torch.einsum("...ij,...j->...i", symmetric(entries[..., 0, :], self.n_q), qd)
