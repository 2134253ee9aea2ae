"""A network of features for T (or L), of any size: see `network_source` for how its rows are differentiated."""

import numpy as np

from repro.learning.affine_rows import affine_rows, has_affine_rows
from repro.learning.kernels.kernel import Kernel
from repro.learning.kernels.network_source import SOURCE
from repro.learning.problem import Problem, Task
from repro.models.lagrangian import Lagrangian


def network_kernel(problem: Problem) -> Kernel | None:
    """The kernel of a problem whose rows need no mass matrix, or None."""
    model = problem.model
    if not isinstance(model, Lagrangian) or model.network is None or not has_affine_rows(problem):
        return None
    source, data = [_constants(model), SOURCE], []
    for number, task in enumerate(problem.tasks):
        packed, rows, valued = _pack(model, task)
        source.append(f"#define gradient_{number}(...) network_gradient(__VA_ARGS__, {rows}, {int(valued)})\n")
        data.append(packed)
    return Kernel("".join(source), data)


def _constants(model: Lagrangian) -> str:
    network = model.network
    assert network is not None
    constants = {
        "INPUTS": network.n_in,
        "LAYERS": len(network.hidden),
        "WIDTHS": ", ".join(map(str, network.hidden)),
        "POTENTIAL": len(model.potential_features),
        "TANH": int(network.activation == "tanh"),
        "VALUES": network.n_parameters,
    }
    return "".join(f"#define {name} {value}\n" for name, value in constants.items())


def _pack(model: Lagrangian, task: Task) -> tuple[np.ndarray, int, bool]:
    """Samples (member, sample, column), the number of rows, and whether a row has a value of the network."""
    affine = affine_rows(model, task)
    valued = bool(affine.value.any())
    parts = [affine.z, affine.zdot]
    for row in range(affine.right.shape[-1]):
        value = [affine.value[..., row, None]] if valued else []
        parts += [*value, *(part[:, :, row] for part in (affine.slope, affine.curvature, affine.potential))]
        parts.append(affine.right[..., row, None])
    packed = np.concatenate([part.double().numpy() for part in parts], axis=-1)
    return packed, affine.right.shape[-1], valued
