"""Predictions of a fitted model at many samples, and the true quantities there."""

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import lru_cache

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.c_library import has_compiler
from repro.codegen.lazy_torch import torch
from repro.codegen.point_function import LEAST_POINTS
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.expression import ExpressionModel
from repro.models.model import SAMPLES, Model, tensors
from repro.models.terms import Terms

CHUNK = 256  # samples at a time: wide networks fit into memory, and what a layer makes fits into the cache
MOST_PARAMETERS = 400  # above this an expression is too long to compile, and matrix products win


def predict(
    model: Model, parameters: np.ndarray, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray
) -> Terms:
    """Predictions of every member at its own samples, as numpy arrays; q, qd, qdd, tau: (member, sample, n_q).

    The acceleration is solved for where the model has a mass matrix only; the error of eq. (12b) is left out. Many
    samples of a small model are predicted by compiled code, and those of a linear one by its expressions at least.
    """
    weights, arrays = np.asarray(parameters, dtype=float), (q, qd, qdd, tau)
    many = q.shape[1] >= LEAST_POINTS and has_compiler()
    if model.not_symbolic is None and (many or model.linear_in_weights) and 0 < model.n_parameters <= MOST_PARAMETERS:
        pairs = zip(*arrays, weights, strict=True)
        return _split(model, np.stack([evaluate(_quantities(model), *of_member) for of_member in pairs]))
    if isinstance(model, ExpressionModel) and not model.n_parameters:
        terms = model.without_weights(np.concatenate(arrays, axis=-1))
        if terms.mass is None:
            return replace(terms, port_error=None)
        return _split(model, evaluate(_quantities(model), *arrays))
    filled: dict[str, np.ndarray] = {}
    for member in range(len(q)):
        own = slice(member, member + 1)
        for start in range(0, q.shape[1], CHUNK):
            chunk = slice(start, start + CHUNK)
            part = [np.require(array[own, chunk], requirements=("C", "W")) for array in arrays]
            for name, values in _by_torch(model, weights[own], part).items():
                if name not in filled:
                    filled[name] = np.empty((*q.shape[:2], *values.shape[2:]), values.dtype)
                # small results that are kept until the end would split the memory that the next chunk could reuse
                filled[name][own, chunk] = values
    return Terms(**filled)


def _by_torch(model: Model, weights: np.ndarray, samples: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
    """What one member predicts at a few samples, (1, sample, ...), by the model's own evaluation."""
    prepared = tensors(model.prepare(*samples))
    with torch.no_grad():
        terms = model.evaluate(torch.from_numpy(weights), prepared, mass=True)
        acceleration = terms.acceleration
        if acceleration is None and terms.mass is not None:
            measured = torch.from_numpy(samples[2])
            acceleration = measured + terms.acceleration_error(measured, torch.from_numpy(samples[3]))
    terms = replace(terms, acceleration=acceleration, port_error=None, implicit_error=None)
    columns = {field.name: getattr(terms, field.name) for field in fields(Terms)}
    return {name: np.asarray(values) for name, values in columns.items() if values is not None}


@lru_cache(maxsize=16)
def _quantities(model: Model) -> casadi.Function:
    """(q, qd, qdd, tau, parameters) -> [qdd | tau | p | T | V | M | p_tran]; of a model without energies the first."""
    q, qd, qdd, tau, parameters = model.symbols(*SAMPLES)
    rows = [model.acceleration(q, qd, tau, parameters)]
    if model.energetic:
        energies, mass = model.energies(q, qd, parameters), casadi.vec(model.mass_matrix(q, qd, parameters))
        rows += [model.inverse_dynamics(q, qd, qdd, parameters), model.momentum(q, qd, parameters)]
        rows += [energies.kinetic, energies.potential, mass]
    if model.transforms:
        rows.append(model.transformed_momentum(q, qd, parameters))
    return column_function("quantities", [q, qd, qdd, tau, parameters], *rows)


def _split(model: Model, rows: np.ndarray) -> Terms:
    """The quantities (member, sample, row), taken apart."""
    n_q = model.n_q
    if not model.energetic:
        return Terms(acceleration=rows)
    acceleration, tau, momentum, energies, mass, transformed = np.split(
        rows, np.cumsum([n_q, n_q, n_q, 2, n_q * n_q]), axis=-1
    )
    return Terms(
        tau=tau,
        momentum=momentum,
        kinetic=energies[..., 0],
        potential=energies[..., 1],
        mass=mass.reshape(*mass.shape[:-1], n_q, n_q),
        transformed_momentum=transformed if model.transforms else None,
        acceleration=acceleration,
    )


def at_rest(model: Model, parameters: np.ndarray, q: np.ndarray) -> Terms:
    """Predictions at positions q (member, sample, n_q) without motion or force."""
    zero = np.zeros_like(q)
    return predict(model, parameters, q, zero, zero, zero)


def truth(system: System, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> Terms:
    """The true system's quantities at the samples; tau and the acceleration are passed through."""
    dynamics = dynamics_of(system)
    kinetic, potential = (evaluate(energy, q, qd)[..., 0] for energy in (dynamics.kinetic, dynamics.potential))
    if system.is_coupled:  # the term belongs to L, so to T as models have it
        kinetic = evaluate(dynamics.lagrangian, q, qd)[..., 0] + potential
    return Terms(
        tau=tau,
        acceleration=qdd,
        momentum=evaluate(dynamics.momentum, q, qd),
        kinetic=kinetic,
        potential=potential,
        mass=evaluate(dynamics.mass_matrix, q, qd).reshape(*q.shape, system.n_q),
    )
