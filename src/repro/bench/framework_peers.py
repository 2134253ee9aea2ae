"""The training step in JAX and by torch.compile.

In JAX sample by sample: the Lagrangian neural network as published, which solves with the Hessian of each sample,
written anew after Cranmer et al. (2020), arXiv:2003.04630; and our inverse formulation. In both, written once, in the
strongest form, that of this project's own engine: whole batches, one tangent forward and one pass back, the derivatives
of the features prepared beforehand. Only the gradient with respect to the weights is automatic there.
"""

import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import torch

from repro.bench.naive import feed_forward, network_on_basis
from repro.bench.training_case import Equation, Precision, Step, TrainingCase, differentiated


def single_threaded_jax() -> Any:
    """The package, with one thread as all other contenders, and with float64."""
    # read when JAX is first imported
    os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")
    import jax

    jax.config.update("jax_enable_x64", True)
    return jax


def jax_step(case: TrainingCase, equation: Equation) -> Step:
    """Loss and gradient of an ensemble on T2/V1, float64, jit and vmap: forward by the Hessian, inverse without one."""
    jax = single_threaded_jax()
    jnp = jax.numpy
    model, network = network_on_basis(case)
    ends = np.cumsum([np.prod(shape) for shape in network.shapes])

    def lagrangian(weights: Any, q: Any, qd: Any) -> Any:
        parts = jnp.split(weights[: ends[-1]], ends[:-1])
        layers = [part.reshape(shape) for part, shape in zip(parts, network.shapes, strict=True)]
        cosines = jnp.cos(q[1:])
        kinetic = feed_forward(layers, jnp.concatenate([qd, cosines]), jax.nn.softplus)
        return kinetic - weights[model.potential_slice] @ cosines

    def forward(weights: Any, q: Any, qd: Any, qdd: Any, tau: Any) -> Any:
        mass = jax.hessian(lagrangian, 2)(weights, q, qd)
        coupling = jax.jacobian(jax.grad(lagrangian, 2), 1)(weights, q, qd)
        push = jax.grad(lagrangian, 1)(weights, q, qd)
        return jnp.linalg.solve(mass, tau + push - coupling @ qd) - qdd

    def inverse(weights: Any, q: Any, qd: Any, qdd: Any, tau: Any) -> Any:
        slopes = partial(jax.grad(lagrangian, (1, 2)), weights)
        (push, _), (_, rate) = jax.jvp(slopes, (q, qd), (qd, qdd))
        return rate - push - tau

    residual = forward if equation == "forward" else inverse

    def loss(weights: Any, *sample: Any) -> Any:
        rows = jax.vmap(residual, in_axes=(None, 0, 0, 0, 0))(weights, *sample)
        return jnp.mean(jnp.sum(rows**2, axis=-1))

    step = jax.jit(jax.vmap(jax.value_and_grad(loss)))
    data = [jnp.asarray(case.parameters.numpy())]
    data += [jnp.asarray(case.measured(name).numpy()) for name in ("q", "qd", "qdd", "tau")]

    def run() -> tuple[np.ndarray, np.ndarray]:
        losses, gradients = jax.block_until_ready(step(*data))
        return np.asarray(losses), np.asarray(gradients)

    return run


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
