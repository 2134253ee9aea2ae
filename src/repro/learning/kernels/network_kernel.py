"""A network of features for T (or L), of any size, with the inverse or the forward objective."""

import numpy as np
import torch

from repro.codegen.c_source import c_source
from repro.learning.affine_rows import affine_rows, has_affine_rows
from repro.learning.kernels.kernel import Kernel, defines, listed
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
    constants = {
        "INPUTS": network.n_in,
        "LAYERS": len(network.hidden),
        "WIDTHS": listed(network.hidden),
        "POTENTIAL": len(model.potential_features),
        "COORDINATES": model.n_q,
        "TANH": int(network.activation == "tanh"),
        "QUANTITIES": 2,
        "VECTORS": 3 if max(network.hidden) < NARROW else 6,
    }
    return defines(constants)


def _pack(model: Lagrangian, task: TrainingTask, number: int) -> tuple[str, np.ndarray]:
    """The C text of a task's `Form`, and its samples (member, sample, column): [z, zdot, the entries that vary]."""
    affine = affine_rows(model, task)
    entries = [affine.weight.unsqueeze(-1)]
    for row in range(affine.right.shape[-1]):
        several = (affine.slope, affine.curvature, affine.potential)
        entries += [affine.value[..., row, None], *(part[:, :, row] for part in several), affine.right[..., row, None]]
    entries.append(affine.bends.flatten(2))
    columns = [column for part in entries for column in part.double().unbind(-1)]
    fixed = [int(x) if (x := column[0, 0].item()) in (0.0, 1.0) and (column == x).all() else None for column in columns]
    places = [place for place, value in enumerate(fixed) if value is None]
    numbers = [affine.right.shape[-1], affine.bends.shape[2], int(task.objective.mass), int(bool(affine.value.any()))]
    form = [
        f"static const int32_t places_{number}[] = {{{listed([*places, 0])}}};",
        f"static const double fixed_{number}[] = {{{listed(value or 0 for value in fixed)}}};",
        f"static const Form form_{number} = {{{listed(numbers)}, {len(places)}, places_{number}, fixed_{number}}};",
        f"#define gradient_{number}(...) network_gradient(__VA_ARGS__, &form_{number})",
        "",
    ]
    read = torch.stack(
        [*affine.z.double().unbind(-1), *affine.zdot.double().unbind(-1), *(columns[k] for k in places)], -1
    )
    return "\n".join(form), read.contiguous().numpy()
