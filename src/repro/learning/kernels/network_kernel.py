"""A network of features for T (or L), of any size, with the inverse or the forward objective."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from repro.codegen.c_source import c_source
from repro.codegen.lazy_torch import Tensor, torch
from repro.learning.kernels.kernel import Kernel, defines, listed, network_constants
from repro.learning.objective_options import EnergyForm
from repro.learning.objectives import forward, inverse
from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.models.lagrangian import Lagrangian

# C files, each using the ones before
PARTS = ("matrix_products", "activations", "pairs", "inverse_rows", "forward_rows", "passes")
NARROW = 24  # units: below this a small block of samples leaves more of the network in the first cache


def network_kernel(problem: TrainingProblem) -> Kernel | None:
    """The kernel of a problem whose model is a network without a momentum transform, or None."""
    model = problem.model
    if not isinstance(model, Lagrangian) or not has_affine_rows(problem):
        return None
    source, data = [_constants(model), *(c_source(__file__, name) for name in PARTS)], []
    for number, task in enumerate(problem.tasks):
        form, packed = _pack(model, task, number)
        source.append(form)
        data.append(packed)
    return Kernel("".join(source), data)


def _constants(model: Lagrangian) -> str:
    network = model.network
    assert network is not None
    constants = network_constants(network) | {
        "POTENTIAL": len(model.potential_features),
        "COORDINATES": model.n_q,
        "QUANTITIES": 2,
        "VECTORS": 3 if max(network.hidden) < NARROW else 6,
    }
    return defines(constants)


def _pack(model: Lagrangian, task: TrainingTask, number: int) -> tuple[str, np.ndarray]:
    """The C text of a task's `Form`, and its samples (member, sample, column): [z, zdot, the entries that vary]."""
    members = [_entries(affine_rows(model, task.member(member))) for member in range(len(task.measured["q"]))]
    columns = range(len(members[0].fixed))
    same = [members[0].fixed[k] if all(m.fixed[k] == members[0].fixed[k] for m in members) else None for k in columns]
    places = [place for place, value in enumerate(same) if value is None]
    rows, bends, valued = members[0].sizes
    numbers = [rows, bends, int(task.objective.mass), int(valued)]
    form = [
        f"static const int32_t places_{number}[] = {{{listed([*places, 0])}}};",
        f"static const real fixed_{number}[] = {{{listed(value or 0 for value in same)}}};",
        f"static const Form form_{number} = {{{listed(numbers)}, {len(places)}, places_{number}, fixed_{number}}};",
        f"#define gradient_{number}(...) network_gradient(__VA_ARGS__, &form_{number})",
        "",
    ]
    return "\n".join(form), np.stack([member.packed(places) for member in members])


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


@dataclass(frozen=True)
class _Entries:
    """The samples of one member: z and zdot (sample, 2 n_z), and of [weight, rows, bends] what varies.

    fixed: 0 or 1 of an entry with this value at every sample, else None; varying: its columns by place, (sample,);
    sizes: rows, bends, and whether some row needs N itself.
    """

    inputs: np.ndarray
    fixed: list[int | None]
    varying: dict[int, np.ndarray]
    sizes: tuple[int, int, bool]

    def packed(self, places: Sequence[int]) -> np.ndarray:
        """Columns [z, zdot, the entries at these places]."""
        samples = len(self.inputs)
        columns = [self.varying.get(k, np.full(samples, self.fixed[k], dtype=float)) for k in places]
        return np.concatenate([self.inputs, *(column[:, None] for column in columns)], axis=1)


def _entries(affine: AffineRows) -> _Entries:
    parts = [affine.weight.unsqueeze(-1)]
    for row in range(affine.right.shape[-1]):
        several = (affine.slope, affine.curvature, affine.potential)
        parts += [affine.value[..., row, None], *(part[:, :, row] for part in several), affine.right[..., row, None]]
    parts.append(affine.bends.flatten(2))
    columns = [column for part in parts for column in part[0].double().unbind(-1)]
    fixed = [int(x) if (x := column[0].item()) in (0.0, 1.0) and (column == x).all() else None for column in columns]
    return _Entries(
        torch.cat([affine.z[0], affine.zdot[0]], dim=1).double().numpy(),
        fixed,
        {k: columns[k].numpy().copy() for k, value in enumerate(fixed) if value is None},
        (affine.right.shape[-1], affine.bends.shape[2], bool(affine.value.any())),
    )
