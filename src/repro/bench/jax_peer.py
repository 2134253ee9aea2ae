"""The same step in JAX: the Lagrangian neural network as published, and our inverse formulation.

Written anew: the LNN after Cranmer et al. (2020), arXiv:2003.04630, which solves with the Hessian of each sample.
"""

import os
from functools import partial
from typing import Any

import numpy as np

from repro.bench.naive import feed_forward, network_on_basis
from repro.bench.training_case import Equation, Step, TrainingCase


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
