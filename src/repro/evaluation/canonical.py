"""The gauge of a learned Lagrangian, and how to fix it.

L, L + constant and L + dF(q)/dt give the same motion, and where T sees cos(q) the split into T and V is free too. The
canonical form takes away what can be taken away without touching the motion:

    T~ = T(q, qd) - T(q, 0) - dF/dq . qd,     V~ = V(q) - T(q, 0),

so that T~(q, 0) = 0. Only the part of a(q) = dL/dqd(q, 0) that is a gradient dF/dq is a gauge; the rest is a false
gyroscopic force and is reported as the remainder.
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np
from torch import Tensor

from repro.codegen.array_evaluation import evaluate
from repro.evaluation.predictions import Predictions, predict
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.model import Model

Reading = Literal["raw", "anchor", "canonical", "canonical_anchor"]
HARMONICS = 3


@dataclass(frozen=True)
class Gauge:
    """How a fitted ensemble's energies are read: `raw`, with one known energy as `anchor`, `canonical`, or both.

    The anchor is the paper's (III-A.1): the energy of one state is known; here the upright rest, where H is V.
    """

    model: Model
    parameters: Tensor
    system: System
    reading: Reading

    def apply(self, predictions: Predictions, q: np.ndarray, qd: np.ndarray) -> Predictions:
        """The same predictions with T and V read in this gauge."""
        kinetic, potential = self._read(predictions, q, qd)
        if self.reading.endswith("anchor"):
            potential = potential - self._anchor_error()
        return replace(predictions, kinetic=kinetic, potential=potential)

    def remainder(self, q: np.ndarray) -> np.ndarray:
        """Mean over samples and components of |dL/dqd(q, 0) - dF/dq|, a member each, in kg m/s and kg m^2/s."""
        momentum = self._at_rest(q).momentum
        gradients = np.stack([_gradient_part(self.system, *pair) for pair in zip(q, momentum, strict=True)])
        return np.abs(momentum - gradients).mean((1, 2))

    def _read(self, predictions: Predictions, q: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if not self.reading.startswith("canonical"):
            return predictions.kinetic, predictions.potential
        rest = self._at_rest(q)
        gradients = np.stack([_gradient_part(self.system, *pair) for pair in zip(q, rest.momentum, strict=True)])
        kinetic = predictions.kinetic - rest.kinetic - (gradients * qd).sum(-1)
        return kinetic, predictions.potential - rest.kinetic

    def _anchor_error(self) -> np.ndarray:
        members = len(self.parameters)
        q = np.broadcast_to(self.system.upright, (members, 1, self.system.n_q))
        zero = np.zeros_like(q)
        rest = predict(self.model, self.parameters, q, zero, zero, zero)
        known = evaluate(dynamics_of(self.system).hamiltonian, self.system.upright, np.zeros(self.system.n_q))[0]
        if self.reading == "canonical_anchor":
            return rest.potential - rest.kinetic - known
        return rest.kinetic + rest.potential - known

    def _at_rest(self, q: np.ndarray) -> Predictions:
        zero = np.zeros_like(q)
        return predict(self.model, self.parameters, q, zero, zero, zero)


def _gradient_part(system: System, q: np.ndarray, field: np.ndarray) -> np.ndarray:
    """The gradient dF/dq, F linear plus trigonometric in the angles, closest to a field; q, field: (sample, n_q)."""
    gradients = [np.broadcast_to(np.eye(system.n_q)[c], q.shape) for c in range(system.n_q)]
    angles = list(system.angles)
    for harmonics in product(range(-HARMONICS, HARMONICS + 1), repeat=len(angles)):
        leading = next((h for h in harmonics if h), 0)
        if leading <= 0:  # cos and sin of the mirrored combination are the same functions
            continue
        phase = q[:, angles] @ np.array(harmonics)
        direction = np.zeros(system.n_q)
        direction[angles] = harmonics
        gradients += [np.outer(-np.sin(phase), direction), np.outer(np.cos(phase), direction)]
    columns = np.stack([gradient.ravel() for gradient in gradients], axis=1)
    solution, *_ = np.linalg.lstsq(columns, field.ravel(), rcond=None)
    return (columns @ solution).reshape(field.shape)
