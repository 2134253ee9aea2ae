"""Residual rows of a Lagrangian as linear functions of what its weights make: N, DN, D^2 N[zdot] and beta."""

from dataclasses import dataclass

from repro.codegen.lazy_torch import Tensor, torch
from repro.learning.objective_options import EnergyForm
from repro.learning.objectives import forward, inverse
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.models.lagrangian import Lagrangian


@dataclass(frozen=True)
class AffineRows:
    """Rows r = value N + slope . DN + curvature . D^2 N[zdot] + potential . beta - right, for the network N(z) of T.

    z, zdot: (member, sample, n_z); value, right: (member, sample, row); slope, curvature: (member, sample, row, n_z);
    potential: (member, sample, row, n_V). For the forward equation the first n_q rows are those of tau, and `bends`
    (member, sample, n_q (n_q + 1) / 2, n_z) are the v_cd of the mass matrix; otherwise there are none.
    weight: (member, sample), of the squared rows.
    """

    z: Tensor
    zdot: Tensor
    value: Tensor
    slope: Tensor
    curvature: Tensor
    potential: Tensor
    right: Tensor
    bends: Tensor
    weight: Tensor


def has_affine_rows(problem: TrainingProblem) -> bool:
    """Whether the rows of every task are made in this way: without a momentum transform."""
    model, objectives = problem.model, [task.objective for task in problem.tasks]
    if not isinstance(model, Lagrangian) or model.network is None or model.transform is not None:
        return False
    known = (inverse.Options, forward.Options, type(None))
    return all(type(o.equation) in known and not o.momentum_weight for o in objectives)


def affine_rows(model: Lagrangian, task: TrainingTask) -> AffineRows:
    """The rows of one task, in the order of `Objective.rows`, and what the mass matrix needs."""
    n_q, objective, measured = model.n_q, task.objective, task.measured
    kinetic = task.prepared["kinetic"]
    z, zdot, u, w, bends = torch.split(kinetic, [1, 1, n_q, n_q, kinetic.shape[2] - 2 - 2 * n_q], dim=2)
    energy, force = torch.split(task.prepared["potential"], [1, n_q], dim=2)
    parts = []
    if objective.equation is not None:
        parts.append((torch.zeros_like(measured["tau"]), w, u, -force, measured["tau"]))
    if objective.energy_weight:
        scale, along = objective.energy_weight**0.5, (measured["qd"].unsqueeze(2) @ u)
        sign, slope = (1.0, torch.zeros_like(z)) if objective.energy_form == EnergyForm.SUM else (-1.0, along)
        known = measured["energy"].unsqueeze(-1)
        value = torch.full_like(known, sign)
        parts.append((scale * value, scale * slope, torch.zeros_like(z), scale * energy, scale * known))
    value, slope, curvature, potential, right = (torch.cat(part, dim=2) for part in zip(*parts, strict=True))
    weight = torch.ones_like(kinetic[:, :, 0, 0]) if task.sample_weight is None else torch.as_tensor(task.sample_weight)
    bends = bends if objective.mass else bends[:, :, :0]
    return AffineRows(z[:, :, 0], zdot[:, :, 0], value, slope, curvature, potential, right, bends, weight)
