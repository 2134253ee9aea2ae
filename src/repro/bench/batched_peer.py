"""The inverse step in the strongest form for JAX and torch.compile: whole batches, no derivative left to the framework.

Written once for both: one tangent forward and one pass back through the network, with the derivatives of the features
prepared beforehand, as in this project's own engine. Only the gradient with respect to the weights is automatic.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch

from repro.bench.jax_peer import single_threaded_jax
from repro.bench.naive import network_on_basis
from repro.bench.training_case import Precision, Step, TrainingCase, differentiated


def jax_batched_step(case: TrainingCase, precision: Precision) -> Step:
    """Loss and gradient by jit; one member."""
    jax = single_threaded_jax()
    real = getattr(jax.numpy, precision)
    loss = _loss(case, lambda array: jax.numpy.asarray(array, real), jax.nn.softplus, jax.nn.sigmoid)
    step, weights = jax.jit(jax.value_and_grad(loss)), jax.numpy.asarray(case.parameters[0].numpy(), real)

    def run() -> tuple[np.ndarray, np.ndarray]:
        value, gradient = jax.block_until_ready(step(weights))
        return np.asarray(value)[None], np.asarray(gradient)[None]

    return run


def torch_compiled_step(case: TrainingCase, precision: Precision) -> Step:
    """Loss and gradient by torch.compile; one member."""
    real = getattr(torch, precision)
    softplus, sigmoid = torch.nn.functional.softplus, torch.sigmoid
    compiled = torch.compile(_loss(case, lambda array: torch.from_numpy(array).to(real), softplus, sigmoid))
    return differentiated(lambda weights: compiled(weights[0])[None], case.parameters.to(real))


def _loss(
    case: TrainingCase,
    array: Callable[[np.ndarray], Any],
    softplus: Callable[[Any], Any],
    sigmoid: Callable[[Any], Any],
) -> Callable[[Any], Any]:
    model, network = network_on_basis(case)
    (task,), n_q, shapes = case.problem("inverse").tasks, case.model.n_q, network.shapes
    # per sample: z, zdot (n_z,); u, w (n_q, n_z); force (n_q, n_V); tau (n_q,)
    rows = task.prepared["kinetic"][0].numpy()
    parts = rows[:, 0], rows[:, 1], rows[:, 2 : 2 + n_q], rows[:, 2 + n_q : 2 + 2 * n_q]
    measured = task.prepared["potential"][0, :, 1:].numpy(), task.measured["tau"][0].numpy()
    z, zdot, u, w, slopes, tau = (array(np.ascontiguousarray(part)) for part in (*parts, *measured))
    ends = np.cumsum([np.prod(shape) for shape in shapes]).tolist()
    potential = model.potential_slice

    def loss(weights: Any) -> Any:
        starts = [0, *ends]
        arrays = [weights[a:b].reshape(shape) for a, b, shape in zip(starts, ends, shapes, strict=False)]
        gradient, rate = _lie_gradient(arrays, z, zdot, softplus, sigmoid)
        force = (u * rate[:, None]).sum(-1) + (w * gradient[:, None]).sum(-1)
        error = force - slopes @ weights[potential] - tau
        return (error * error).sum() / len(tau)

    return loss


def _lie_gradient(
    arrays: Sequence[Any], value: Any, rate: Any, softplus: Callable[[Any], Any], sigmoid: Callable[[Any], Any]
) -> tuple[Any, Any]:
    """DN and its rate D^2 N[zdot] at the inputs (sample, n_z)."""
    slopes = []
    for weight, bias in zip(arrays[0:-2:2], arrays[1:-2:2], strict=True):
        before, before_rate = value @ weight.T + bias, rate @ weight.T
        first = sigmoid(before)
        value, rate = softplus(before), first * before_rate
        slopes.append((first, first * (1 - first) * before_rate))
    gradient, gradient_rate = arrays[-2], 0 * arrays[-2]
    for weight, (first, first_rate) in zip(arrays[-4::-2], reversed(slopes), strict=True):
        gradient_rate = (first * gradient_rate + first_rate * gradient) @ weight
        gradient = (first * gradient) @ weight
    return gradient, gradient_rate
