"""The transformation from velocities to momenta as a network of its own: p_tran = M_hat(q) qd, eq. (8)."""

from collections.abc import Sequence

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.models.features import FeatureMap
from repro.models.network import Network
from repro.models.position import PositionFeatures
from repro.models.terms import symmetric


class MomentumTransform:
    """M_hat(q): a network on the position features whose outputs are the entries of a symmetric matrix."""

    def __init__(self, n_q: int, hidden: Sequence[int], positions: PositionFeatures) -> None:
        self.n_q, self.features = n_q, FeatureMap(positions.inertia, n_q)
        self.network = Network(len(self.features), tuple(hidden), n_q * (n_q + 1) // 2)
        self.n_parameters, self.initial = self.network.n_parameters, self.network.initial

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
