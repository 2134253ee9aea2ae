"""The usual way: the Lagrangian of one sample as a function, its Hessian by torch.func, and a batch by vmap.

Forward, this is the Lagrangian neural network of Cranmer et al. (2020). With the engineered features and the inverse
equation it stands for the LINN of Bao et al. (2021), whose code is not public.
"""

from collections.abc import Callable

import torch
from torch import Tensor
from torch.func import grad, hessian, vmap

from repro.bench.step import Step, differentiated
from repro.bench.training_case import Equation, TrainingCase
from repro.models.lagrangian import Lagrangian

# q, qd (n_q,) -> inputs of the network, features of V. Written for whole vectors, which is quicker than by components.
Features = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]


def t2_features(q: Tensor, qd: Tensor) -> tuple[Tensor, Tensor]:
    """The basis T2/V1."""
    cosines = torch.cos(q[1:])
    return torch.cat([qd, cosines]), cosines


def engineered_features(q: Tensor, qd: Tensor) -> tuple[Tensor, Tensor]:
    """[q; qd; cos q; sin q] for L as a whole, and no V."""
    return torch.cat([q, qd, torch.cos(q), torch.sin(q)]), q[:0]


def naive_step(case: TrainingCase, equation: Equation, features: Features) -> Step:
    """Loss and gradient of an ensemble of networks, one member after another."""
    model = case.model
    if not isinstance(model, Lagrangian) or model.network is None:
        raise TypeError("the naive way is written for networks on a basis")
    network = model.network
    x = torch.cat([case.measured("q"), case.measured("qd")], dim=-1)
    qdd, tau = case.measured("qdd"), case.measured("tau")

    def member_loss(weights: Tensor, member: int) -> Tensor:
        layers = [array[0] for array in network.unpack(weights[None, model.kinetic_slice])]
        beta = weights[model.potential_slice]

        def lagrangian(x: Tensor) -> Tensor:
            output, potential = features(*x.chunk(2))
            for weight, bias in zip(layers[0:-2:2], layers[1:-2:2], strict=True):
                output = torch.nn.functional.softplus(weight @ output + bias, threshold=40.0)
            return (layers[-2] @ output + layers[-1])[0] - beta @ potential

        def residual(x: Tensor, qdd: Tensor, tau: Tensor) -> Tensor:
            return _residual(lagrangian, equation, x, qdd, tau)

        rows = vmap(residual)(x[member], qdd[member], tau[member])
        return rows.square().sum() / len(rows)

    def loss(parameters: Tensor) -> Tensor:
        return torch.stack([member_loss(weights, member) for member, weights in enumerate(parameters)])

    return differentiated(loss, case.parameters)


def _residual(
    lagrangian: Callable[[Tensor], Tensor], equation: Equation, x: Tensor, qdd: Tensor, tau: Tensor
) -> Tensor:
    """Eq. (2) and its solution for qdd, from the Hessian in x = [q; qd] (2 n_q,)."""
    n_q = len(qdd)
    curvature = hessian(lagrangian)(x)
    slope = grad(lagrangian)(x)
    mass, coupling = curvature[n_q:, n_q:], curvature[n_q:, :n_q]
    rest = coupling @ x[n_q:] - slope[:n_q]
    if equation == "inverse":
        error: Tensor = mass @ qdd + rest - tau
    else:
        error = torch.linalg.solve(mass, tau - rest) - qdd
    return error
