"""What a fitted model says of many samples, and what is true of them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.model import Model

CHUNK = 4096  # samples at a time, so that wide networks fit into memory


Quantity = Any  # an array, or None where it is not defined


@dataclass(frozen=True)
class Predictions:
    """Arrays of one model or of the truth; None where a quantity is not defined.

    tau, qdd, momentum, transformed_momentum: (member, sample, n_q); kinetic, potential: (member, sample) in J;
    mass: (member, sample, n_q, n_q).
    """

    tau: Quantity = None
    qdd: Quantity = None
    momentum: Quantity = None
    kinetic: Quantity = None
    potential: Quantity = None
    mass: Quantity = None
    transformed_momentum: Quantity = None

    @property
    def lagrangian(self) -> np.ndarray:
        """L = T - V, (member, sample) in J."""
        return self.kinetic - self.potential

    def hamiltonian(self, qd: np.ndarray) -> np.ndarray:
        """The Legendre transform p . qd - L, (member, sample) in J."""
        return (self.momentum * qd).sum(-1) - self.lagrangian


def predict(
    model: Model, parameters: Tensor, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray
) -> Predictions:
    """Predictions of every member at its own samples; q, qd, qdd, tau: (member, sample, n_q)."""
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
        chunks.append(
            {
                "tau": terms.tau,
                "qdd": acceleration,
                "momentum": terms.momentum,
                "kinetic": terms.kinetic,
                "potential": terms.potential,
                "mass": terms.mass,
                "transformed_momentum": terms.transformed_momentum,
            }
        )
    joined = {
        name: None if chunks[0][name] is None else torch.cat([chunk[name] for chunk in chunks], dim=1).numpy()
        for name in chunks[0]
    }
    return Predictions(**joined)


def truth(system: System, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> Predictions:
    """The true system's quantities at the samples; qdd and tau are passed through."""
    dynamics = dynamics_of(system)
    return Predictions(
        tau=tau,
        qdd=qdd,
        momentum=evaluate(dynamics.momentum, q, qd),
        kinetic=evaluate(dynamics.kinetic, q, qd)[..., 0],
        potential=evaluate(dynamics.potential, q, qd)[..., 0],
        mass=evaluate(dynamics.mass_matrix, q, qd),
    )
