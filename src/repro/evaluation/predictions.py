"""Predictions of a fitted model at many samples, and the true quantities there."""

from dataclasses import fields, replace

import numpy as np
import torch
from torch import Tensor

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.model import Model
from repro.models.terms import Terms

CHUNK = 4096  # samples at a time, so that wide networks fit into memory


def predict(model: Model, parameters: Tensor, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> Terms:
    """Predictions of every member at its own samples, as numpy arrays; q, qd, qdd, tau: (member, sample, n_q).

    The acceleration is solved for where the model has a mass matrix only; the error of eq. (12b) is left out.
    """
    chunks = []
    weights = parameters.double()
    for start in range(0, q.shape[1], CHUNK):
        part = [np.ascontiguousarray(array[:, start : start + CHUNK]) for array in (q, qd, qdd, tau)]
        prepared = {name: torch.from_numpy(array) for name, array in model.prepare(*part).items()}
        with torch.no_grad():
            terms = model.evaluate(weights, prepared, mass=True)
            acceleration = terms.acceleration
            if acceleration is None and terms.mass is not None:
                measured = torch.from_numpy(part[2])
                acceleration = measured + terms.acceleration_error(measured, torch.from_numpy(part[3]))
        chunks.append(replace(terms, acceleration=acceleration, port_error=None))

    def joined(name: str) -> np.ndarray | None:
        parts = [getattr(chunk, name) for chunk in chunks]
        return None if parts[0] is None else torch.cat(parts, dim=1).numpy()

    return Terms(**{field.name: joined(field.name) for field in fields(Terms)})


def at_rest(model: Model, parameters: Tensor, q: np.ndarray) -> Terms:
    """Predictions at positions q (member, sample, n_q) without motion or force."""
    zero = np.zeros_like(q)
    return predict(model, parameters, q, zero, zero, zero)


def truth(system: System, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> Terms:
    """The true system's quantities at the samples; tau and the acceleration are passed through."""
    dynamics = dynamics_of(system)
    return Terms(
        tau=tau,
        acceleration=qdd,
        momentum=evaluate(dynamics.momentum, q, qd),
        kinetic=evaluate(dynamics.kinetic, q, qd)[..., 0],
        potential=evaluate(dynamics.potential, q, qd)[..., 0],
        mass=evaluate(dynamics.mass_matrix, q, qd),
    )
