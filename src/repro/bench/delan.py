"""Deep Lagrangian networks (Lutter, Ritter and Peters 2019, arXiv:1907.04490) with automatic derivatives.

Their analytic form, with the derivatives by the chain rule through the layers, is this project's triangular factor.
"""

import torch
from torch import Tensor
from torch.func import jacfwd, vmap

from repro.bench.training_case import Loss, Step, TrainingCase, step_of_each
from repro.models.kinds.structured import Structured
from repro.models.position import cart_with_links


def automatic_loss(case: TrainingCase) -> Loss:
    """The loss on tau of a triangular factor of M, with dM/dq and dV/dq by jacfwd at every sample."""
    model = case.model
    if not isinstance(model, Structured) or model.rank != model.n_q:
        raise TypeError("this way is written for a triangular factor")
    positions, scale = cart_with_links(model.n_q), torch.from_numpy(model.velocity_scale)
    data = [case.measured(name) for name in ("q", "qd", "qdd", "tau")]
    places = torch.eye(model.n_q**2).reshape(-1, model.n_q, model.n_q).tril().double()
    places = places[places.sum((1, 2)) > 0]  # of the entries, row by row

    def loss(weights: Tensor, member: int, samples: Tensor | slice) -> Tensor:
        q, qd, qdd, tau = (array[member, samples] for array in data)
        network, beta = weights[None, model.network_slice], weights[model.potential_slice]

        def terms(place: Tensor) -> tuple[Tensor, Tensor]:
            entries = model.network.values(network, positions.values(place)[None, None])[0, 0]
            factor = torch.einsum("e,eij->ij", entries, places)
            matrix = factor @ factor.mT / torch.outer(scale, scale)
            return torch.cat([matrix, (beta @ torch.cos(place[1:])).expand(1, model.n_q)]), matrix

        slopes, mass = vmap(jacfwd(terms, has_aux=True))(q)
        turned = torch.einsum("sijk,sj->sik", slopes[:, :-1], qd)
        inertial = torch.einsum("sij,sj->si", mass, qdd) + torch.einsum("sik,sk->si", turned, qd)
        error = inertial - torch.einsum("sik,si->sk", turned, qd) / 2 + slopes[:, -1, 0] - tau
        mean: Tensor = error.square().sum(1).mean()
        return mean

    return loss


def automatic_step(case: TrainingCase) -> Step:
    """Loss and its gradient, one member after another."""
    return step_of_each(automatic_loss(case), case.parameters)
