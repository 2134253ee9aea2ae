"""Residual rows of a Lagrangian as linear functions of what its weights make: N, DN, D^2 N[zdot] and beta."""

from dataclasses import dataclass

import torch
from torch import Tensor

from repro.learning.problem import Problem, Task
from repro.models.lagrangian import Lagrangian


@dataclass(frozen=True)
class AffineRows:
    """Rows r = value N + slope . DN + curvature . D^2 N[zdot] + potential . beta - right, for the network N(z) of T.

    z, zdot: (member, sample, n_z); value, right: (member, sample, row); slope, curvature: (member, sample, row, n_z);
    potential: (member, sample, row, n_V). A linear basis has N = alpha . z.
    """

    z: Tensor
    zdot: Tensor
    value: Tensor
    slope: Tensor
    curvature: Tensor
    potential: Tensor
    right: Tensor

    @property
    def columns(self) -> Tensor:
        """The rows' derivatives (member, sample, row, n_z + n_V) with respect to [alpha, beta] of a linear basis."""
        kinetic = self.slope + self.value.unsqueeze(-1) * self.z.unsqueeze(2)
        return torch.cat([kinetic, self.potential], dim=-1)


def has_affine_rows(problem: Problem) -> bool:
    """Whether the rows of every task are linear in this way: without a mass matrix or a momentum transform."""
    model, objectives = problem.model, [task.objective for task in problem.tasks]
    if not isinstance(model, Lagrangian) or model.transform is not None:
        return False
    return all(objective.equation != "forward" and not objective.transform_weight for objective in objectives)


def affine_rows(model: Lagrangian, task: Task) -> AffineRows:
    """The rows of one task, in the order of `Objective.rows`, times the square roots of the sample weights."""
    n_q, objective, measured = model.n_q, task.objective, task.measured
    z, zdot, u, w = task.prepared["kinetic"][:, :, : 2 + 2 * n_q].split([1, 1, n_q, n_q], dim=2)
    energy, force = task.prepared["potential"].split([1, n_q], dim=2)
    parts = []
    if objective.equation == "inverse":
        parts.append((torch.zeros_like(measured["tau"]), w, u, -force, measured["tau"]))
    if objective.energy_weight:
        scale, along = objective.energy_weight**0.5, (measured["qd"].unsqueeze(2) @ u)
        sign, slope = (1.0, torch.zeros_like(z)) if objective.energy_form == "sum" else (-1.0, along)
        known = measured["energy"].unsqueeze(-1)
        value = torch.full_like(known, sign)
        parts.append((scale * value, scale * slope, torch.zeros_like(z), scale * energy, scale * known))
    value, slope, curvature, potential, right = (torch.cat(part, dim=2) for part in zip(*parts, strict=True))
    if task.sample_weight is not None:
        root = task.sample_weight.sqrt().unsqueeze(-1)
        value, right = value * root, right * root
        slope, curvature, potential = (part * root.unsqueeze(-1) for part in (slope, curvature, potential))
    return AffineRows(z[:, :, 0], zdot[:, :, 0], value, slope, curvature, potential, right)
