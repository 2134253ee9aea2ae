"""Inverse and forward dynamics of any Lagrangian that torch can differentiate, without its Hessian."""

from collections.abc import Callable

import torch
from torch import Tensor
from torch.autograd import forward_ad

LagrangianFunction = Callable[[Tensor, Tensor], Tensor]  # L (...) of q, qd (..., n_q)

# torch does not annotate these
_dual: Callable[[Tensor, Tensor], Tensor] = forward_ad.make_dual
_parts: Callable[[Tensor], tuple[Tensor, Tensor]] = forward_ad.unpack_dual  # value and tangent


def inverse_dynamics(lagrangian: LagrangianFunction, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
    """tau = d/dt(dL/dqd) - dL/dq, eq. (2), from one directional derivative and one pass back, whatever n_q is.

    q, qd, qdd: (..., n_q). With Ldot the derivative of L along (v, a) at (q, qd), tau = dLdot/dqd - dLdot/dv at v = qd,
    a = qdd. Differentiable with respect to qdd and to the weights inside L.
    """
    force, _ = _lie_gradient(lagrangian, q, qd, qd, qdd)
    return force


def forward_dynamics(lagrangian: LagrangianFunction, q: Tensor, qd: Tensor, tau: Tensor) -> Tensor:
    """The qdd (..., n_q) that solves eq. (2) for tau, from n_q products of the Hessian with a vector.

    Its derivatives are those of one Newton step from the solution, which moves nothing: one inverse residual is
    differentiated, and neither the mass matrix nor its factors. Not finite where the mass matrix is singular.
    """
    rest = inverse_dynamics(lagrangian, q, qd, torch.zeros_like(qd)).detach()
    mass = mass_matrix(lagrangian, q, qd).detach()
    factors, pivots = torch.linalg.lu_factor(mass)

    def solve(right: Tensor) -> Tensor:
        solution: Tensor = torch.linalg.lu_solve(factors, pivots, right.unsqueeze(-1))
        return solution.squeeze(-1)

    solution = solve((tau - rest).detach())
    return solution + solve(tau - inverse_dynamics(lagrangian, q, qd, solution))


def mass_matrix(lagrangian: LagrangianFunction, q: Tensor, qd: Tensor) -> Tensor:
    """M = d2L/dqd2 (..., n_q, n_q), a column for each coordinate."""
    directions = torch.eye(q.shape[-1], dtype=q.dtype, device=q.device)
    still = torch.zeros_like(qd)
    return torch.stack([_lie_gradient(lagrangian, q, qd, still, e.expand_as(qd))[1] for e in directions], dim=-1)


def _lie_gradient(lagrangian: LagrangianFunction, q: Tensor, qd: Tensor, v: Tensor, a: Tensor) -> tuple[Tensor, Tensor]:
    """dLdot/dqd - dLdot/dv and dLdot/dqd, for Ldot the derivative of L along (v, a) at (q, qd)."""
    velocity, along = (x.detach().requires_grad_() for x in (qd, v))
    with torch.enable_grad(), forward_ad.dual_level():
        value = lagrangian(_dual(q, along), _dual(velocity, a))
        _, rate = _parts(value)
        total, push = torch.autograd.grad(rate.sum(), (velocity, along), create_graph=True)
    return total - push, total
