"""Deep Lagrangian networks (Lutter, Ritter and Peters 2019, arXiv:1907.04490), written from the paper."""

from dataclasses import dataclass, field

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import softplus

from repro.bench.training_case import Step, TrainingCase, differentiated
from repro.models.network import Network

SMALLEST = 1e-3  # on the diagonal of the factor


@dataclass(frozen=True)
class DeLaN:
    """One network of q with three heads: the diagonal and the rest of a triangular factor of M = L L', and g(q).

    The derivatives of L with respect to q go through the layers by the chain rule, together with L (section 4.1).
    """

    n_q: int
    hidden: tuple[int, ...]
    network: Network = field(init=False)

    def __post_init__(self) -> None:
        n_out = self.n_q + self.n_q * (self.n_q - 1) // 2 + self.n_q
        object.__setattr__(self, "network", Network(self.n_q, self.hidden, n_out))

    def inverse(self, parameters: Tensor, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
        """tau = M qdd + Mdot qd - (d/dq qd' M qd)' / 2 + g, each (sample, n_q); parameters (n_parameters,)."""
        factor, slopes, force = self.heads(parameters, q)
        rate = torch.einsum("sijk,sk->sij", slopes, qd)
        half = rate @ factor.mT
        mass_rate = half + half.mT
        along, along_slopes = torch.einsum("sij,si->sj", factor, qd), torch.einsum("sijk,si->sjk", slopes, qd)
        push = torch.einsum("sjk,sj->sk", along_slopes, along)  # half of d/dq (qd' L L' qd)
        inertial = torch.einsum("sij,sj->si", factor @ factor.mT, qdd) + torch.einsum("sij,sj->si", mass_rate, qd)
        return inertial - push + force

    def automatic_inverse(self, parameters: Tensor, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
        """The same tau, with dM/dq by automatic differentiation at every sample."""
        arrays = [array[0] for array in self.network.unpack(parameters.unsqueeze(0))]

        def mass(place: Tensor) -> tuple[Tensor, tuple[Tensor, Tensor]]:
            output = place
            for weight, bias in zip(arrays[0:-2:2], arrays[1:-2:2], strict=True):
                output = softplus(weight @ output + bias)
            heads = arrays[-2] @ output + arrays[-1]
            diagonal, lower, force = heads.tensor_split([self.n_q, self.n_q * (self.n_q + 1) // 2])
            factor = self._triangle(torch.cat([softplus(diagonal) + SMALLEST, lower]).unsqueeze(0))[0]
            return factor @ factor.mT, (factor @ factor.mT, force)

        slopes, (matrix, force) = torch.vmap(torch.func.jacfwd(mass, has_aux=True))(q)
        turned = torch.einsum("sijk,sj->sik", slopes, qd)
        inertial = torch.einsum("sij,sj->si", matrix, qdd) + torch.einsum("sik,sk->si", turned, qd)
        tau: Tensor = inertial - torch.einsum("sik,si->sk", turned, qd) / 2 + force
        return tau

    def heads(self, parameters: Tensor, q: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """L (sample, n_q, n_q), dL/dq (sample, n_q, n_q, n_q) with q last, and g (sample, n_q)."""
        arrays = [array[0] for array in self.network.unpack(parameters.unsqueeze(0))]
        output, slope = q, torch.eye(self.n_q, dtype=q.dtype).expand(len(q), -1, -1)
        for weight, bias in zip(arrays[0:-2:2], arrays[1:-2:2], strict=True):
            before = output @ weight.T + bias
            output, slope = softplus(before), torch.sigmoid(before).unsqueeze(-1) * (weight @ slope)
        output, slope = output @ arrays[-2].T + arrays[-1], arrays[-2] @ slope
        n_lower = self.n_q * (self.n_q - 1) // 2
        diagonal, lower, force = output.tensor_split([self.n_q, self.n_q + n_lower], dim=-1)
        diagonal_slope = torch.sigmoid(diagonal).unsqueeze(-1) * slope[:, : self.n_q]
        entries = torch.cat([softplus(diagonal) + SMALLEST, lower], dim=-1)
        entry_slopes = torch.cat([diagonal_slope, slope[:, self.n_q : self.n_q + n_lower]], dim=1)
        return self._triangle(entries), self._triangle(entry_slopes), force

    def _triangle(self, entries: Tensor) -> Tensor:
        """Lower-triangular matrices from (sample, entry, ...): the diagonal first, then the rest by rows."""
        rows, columns = torch.tril_indices(self.n_q, self.n_q, offset=-1)
        diagonal = torch.arange(self.n_q)
        matrix = entries.new_zeros(len(entries), self.n_q, self.n_q, *entries.shape[2:])
        matrix[:, torch.cat([diagonal, rows]), torch.cat([diagonal, columns])] = entries
        return matrix


def delan_step(case: TrainingCase, hidden: tuple[int, ...], automatic: bool = False) -> Step:
    """Loss on tau and its gradient, for the samples of a case with one member; Glorot-uniform weights.

    automatic: the derivatives of M by automatic differentiation, not by the chain rule through the layers.
    """
    peer = DeLaN(case.dataset.n_q, hidden)
    inverse = peer.automatic_inverse if automatic else peer.inverse
    q, qd, qdd, tau = (case.measured(name)[0] for name in ("q", "qd", "qdd", "tau"))

    def loss(weights: Tensor) -> Tensor:
        error = inverse(weights[0], q, qd, qdd) - tau
        return error.square().sum(1).mean().unsqueeze(0)

    return differentiated(loss, torch.from_numpy(peer.network.initial([np.random.default_rng([0, 1])])))
