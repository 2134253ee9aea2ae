"""Symplectic ODE-Net: M^-1(q), V(q) and how inputs act, G(q), as networks; with friction D(q) its dissipative form."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.models.context import Context
from repro.models.model import SAMPLES, Model, Prepared, consecutive
from repro.models.model_options import Activation, ModelOptions
from repro.models.network import Network
from repro.models.position import PositionFeatures
from repro.models.terms import Terms
from repro.plugins.options import Count

FLOOR = 0.1  # added to the diagonal of L L', as published


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=symoden; hidden: of every network; dissipation `state`: D(q) is learned too."""

    controllable: ClassVar[bool] = False
    differentiable: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (64, 64)
    activation: Activation = "tanh"
    dissipation: Literal["none", "state"] = "none"


class SymODEN(Model):
    """p = M(q) qd, qdot = M^-1 p, pdot = -d(p' M^-1 p)/dq / 2 - dV/dq - D qd + G tau (Zhong et al. 2020).

    M^-1 = L L' + FLOOR and D = K K' with lower triangular L, K. G (n_q, n_q) acts on the recorded force, so that an
    input's column is what it makes of the place where the input acts. tau_hat - tau is the residual of this equation.
    parameters: [weights of L | V | G | K].
    """

    not_symbolic = "it learns how inputs act"

    def __init__(self, n_q: int, positions: PositionFeatures, options: Options) -> None:
        self.n_q, self.positions = n_q, positions
        self._entries = np.tril_indices(n_q)  # of numpy: to plan a job loads no torch
        outputs = [len(self._entries[0]), 1, n_q * n_q]
        outputs += [len(self._entries[0])] if options.dissipation == "state" else []
        self.networks = [Network(positions.size, options.hidden, n_out, options.activation) for n_out in outputs]
        self.slices = consecutive(*(network.n_parameters for network in self.networks))
        self.n_parameters = self.slices[-1].stop

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights, zero biases."""
        return np.concatenate([network.initial(generators) for network in self.networks], axis=1)

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """L and V with their slopes (..., 1 + n_q, n_out), G and, with friction, K (..., 1, n_out)."""
        jets = self.positions.slopes(prepared["q"])
        pairs = [(network, parameters[:, place]) for network, place in zip(self.networks, self.slices, strict=True)]
        moving = [network.propagate(weights, jets) for network, weights in pairs[:2]]
        return moving + [network.values(weights, jets[:, :, 0]).unsqueeze(2) for network, weights in pairs[2:]]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """The motion, the energies, and the residual as a force."""
        q, qd, qdd, tau = (prepared[name] for name in SAMPLES)
        factor, potential = self._lower(outputs[0]), outputs[1][..., 0]
        inverse = factor[:, :, 0] @ factor[:, :, 0].mT + FLOOR * torch.eye(self.n_q, dtype=q.dtype)
        half = factor[:, :, 1:] @ factor[:, :, :1].mT
        slopes = half + half.mT
        inertia = torch.linalg.inv_ex(inverse)[0]
        momentum = (inertia @ qd.unsqueeze(-1)).squeeze(-1)
        push = (outputs[2][:, :, 0].unflatten(-1, (self.n_q, self.n_q)) @ tau.unsqueeze(-1)).squeeze(-1)
        push = push - potential[..., 1:] - torch.einsum("mnkij,mni,mnj->mnk", slopes, momentum, momentum) / 2
        if len(outputs) > 3:
            friction = self._lower(outputs[3])[:, :, 0]
            push = push - (friction @ (friction.mT @ qd.unsqueeze(-1))).squeeze(-1)
        turning = torch.einsum("mnkij,mnk,mnj->mni", slopes, qd, momentum)
        acceleration = turning + (inverse @ push.unsqueeze(-1)).squeeze(-1)
        return Terms(
            tau=tau + (inertia @ (qdd - acceleration).unsqueeze(-1)).squeeze(-1),
            momentum=momentum,
            kinetic=(momentum * qd).sum(-1) / 2,
            potential=potential[..., 0],
            mass=inertia,
            acceleration=acceleration,
        )

    def acceleration_at(self, parameters: Tensor, q: Tensor, qd: Tensor, tau: Tensor) -> Tensor:
        """qdd (member, sample, n_q), differentiable in all arguments."""
        prepared = dict(zip(SAMPLES, (q, qd, torch.zeros_like(q), tau), strict=True))
        acceleration: Tensor = self.evaluate(parameters, prepared).acceleration
        return acceleration

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        jets = self.positions.slopes(prepared["q"])
        parts = [
            network.jacobian(parameters[:, place], jets[:, :, : cotangent.shape[-2]], cotangent)
            for network, place, cotangent in zip(self.networks, self.slices, cotangents, strict=True)
        ]
        return torch.cat(parts, dim=-1)

    def _lower(self, entries: Tensor) -> Tensor:
        whole = entries.new_zeros((*entries.shape[:-1], self.n_q, self.n_q))
        whole[..., self._entries[0], self._entries[1]] = entries
        return whole


def build(context: Context, options: Options) -> Model:
    """The model."""
    return SymODEN(context.n_q, context.positions, options)
