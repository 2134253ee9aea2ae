"""The usual way: the Lagrangian of one sample as a function, its Hessian by torch.func, and a batch by vmap.

Forward, this is the Lagrangian neural network of Cranmer et al. (2020). With the engineered features and the inverse
equation it stands for the LINN of Bao et al. (2021), whose code is not public. Deep Lagrangian networks (Lutter, Ritter
and Peters 2019, arXiv:1907.04490) are here with automatic derivatives too; their analytic form, with the derivatives by
the chain rule through the layers, is this project's triangular factor.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import torch
from torch import Tensor
from torch.func import grad, hessian, jacfwd, vmap
from torch.nn.functional import softplus

from repro.bench.training_case import Equation, Step, TrainingCase, differentiated
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.models.kinds.structured import Structured
from repro.models.lagrangian import Lagrangian
from repro.models.model import SAMPLES, Model
from repro.models.network import Network
from repro.models.position import cart_with_links

# q, qd (n_q,) -> inputs of the network, features of V. Written for whole vectors, which is quicker than by components.
Features = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]


def t2_features(q: Tensor, qd: Tensor) -> tuple[Tensor, Tensor]:
    """The basis T2/V1."""
    cosines = torch.cos(q[1:])
    return torch.cat([qd, cosines]), cosines


def engineered_features(q: Tensor, qd: Tensor) -> tuple[Tensor, Tensor]:
    """[q; qd; cos q; sin q] for L as a whole, and no V."""
    return torch.cat([q, qd, torch.cos(q), torch.sin(q)]), q[:0]


def network_on_basis(case: TrainingCase) -> tuple[Lagrangian, Network]:
    """The model of a case and its network; TypeError for a model without one."""
    if not isinstance(case.model, Lagrangian) or case.model.network is None:
        raise TypeError("this way is written for networks on a basis")
    return case.model, case.model.network


def feed_forward(layers: Sequence[Any], inputs: Any, activation: Callable[[Any], Any]) -> Any:
    """The scalar output of weights and biases in turn for one sample, as tensors or as arrays of JAX."""
    output = inputs
    for weight, bias in zip(layers[0:-2:2], layers[1:-2:2], strict=True):
        output = activation(weight @ output + bias)
    return (layers[-2] @ output + layers[-1])[0]


@dataclass(frozen=True, kw_only=True)
class MemberTask(TrainingTask):
    """Rows that are written for one member; members follow one after another."""

    rows_of: Callable[..., Tensor]  # weights (n_parameters,), q, qd, qdd, tau (sample, n_q) -> rows (sample, n_q)

    def residuals(self, model: Model, parameters: Tensor) -> Tensor:
        """The rows (member, sample, n_q), scaled as `rows`."""
        arrays = parameters, *(self.measured[name] for name in SAMPLES)
        return torch.stack([self.rows_of(*each) for each in zip(*arrays, strict=True)]) / math.sqrt(self.samples)


def _problem(case: TrainingCase, rows_of: Callable[..., Tensor]) -> TrainingProblem:
    usual = case.problem("inverse")
    (task,) = usual.tasks
    return replace(usual, tasks=[MemberTask(task.model, task.objective, task.recorded, known={}, rows_of=rows_of)])


def naive_problem(case: TrainingCase, equation: Equation, features: Features) -> TrainingProblem:
    """The training problem of an ensemble of networks."""
    model, network = network_on_basis(case)
    n_q, forward = model.n_q, equation == "forward"

    def rows(weights: Tensor, q: Tensor, qd: Tensor, qdd: Tensor, tau: Tensor) -> Tensor:
        layers = [array[0] for array in network.unpack(weights[None, model.kinetic_slice])]
        beta = weights[model.potential_slice]

        def lagrangian(x: Tensor) -> Tensor:
            inputs, potential = features(*x.chunk(2))
            kinetic: Tensor = feed_forward(layers, inputs, partial(softplus, threshold=40.0))
            return kinetic - beta @ potential

        def residual(x: Tensor, qdd: Tensor, tau: Tensor) -> Tensor:
            """Eq. (2), or its solution for qdd, from the Hessian in x = [q; qd] (2 n_q,)."""
            curvature, slope = hessian(lagrangian)(x), grad(lagrangian)(x)
            mass, coupling = curvature[n_q:, n_q:], curvature[n_q:, :n_q]
            rest = coupling @ x[n_q:] - slope[:n_q]
            error: Tensor = torch.linalg.solve(mass, tau - rest) - qdd if forward else mass @ qdd + rest - tau
            return error

        mapped: Tensor = vmap(residual)(torch.cat([q, qd], dim=-1), qdd, tau)
        return mapped

    return _problem(case, rows)


def naive_step(case: TrainingCase, equation: Equation, features: Features) -> Step:
    """Loss and gradient of an ensemble of networks, one member after another."""
    return differentiated(naive_problem(case, equation, features).loss, case.parameters)


def automatic_problem(case: TrainingCase) -> TrainingProblem:
    """The training problem, of tau, of a triangular factor of M, with dM/dq and dV/dq by jacfwd at every sample."""
    model = case.model
    if not isinstance(model, Structured) or model.rank != model.n_q:
        raise TypeError("this way is written for a triangular factor")
    positions, scale = cart_with_links(model.n_q), torch.from_numpy(model.velocity_scale)
    places = torch.eye(model.n_q**2).reshape(-1, model.n_q, model.n_q).tril().double()
    places = places[places.sum((1, 2)) > 0]  # of the entries, row by row

    def rows(weights: Tensor, q: Tensor, qd: Tensor, qdd: Tensor, tau: Tensor) -> Tensor:
        network, beta = weights[None, model.network_slice], weights[model.potential_slice]

        def terms(place: Tensor) -> tuple[Tensor, Tensor]:
            entries = model.network.values(network, positions.values(place)[None, None])[0, 0]
            factor = torch.einsum("e,eij->ij", entries, places)
            matrix = factor @ factor.mT / torch.outer(scale, scale)
            return torch.cat([matrix, (beta @ torch.cos(place[1:])).expand(1, model.n_q)]), matrix

        slopes, mass = vmap(jacfwd(terms, has_aux=True))(q)
        turned = torch.einsum("sijk,sj->sik", slopes[:, :-1], qd)
        inertial = torch.einsum("sij,sj->si", mass, qdd) + torch.einsum("sik,sk->si", turned, qd)
        error: Tensor = inertial - torch.einsum("sik,si->sk", turned, qd) / 2 + slopes[:, -1, 0] - tau
        return error

    return _problem(case, rows)


def automatic_step(case: TrainingCase) -> Step:
    """Loss and its gradient, one member after another."""
    return differentiated(automatic_problem(case).loss, case.parameters)
