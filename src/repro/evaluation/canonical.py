"""The gauge of a learned Lagrangian, and how to fix it.

L, L + constant and L + dF(q)/dt give the same motion, and where T sees cos(q) the split into T and V is free too. The
canonical form takes away what can be taken away without touching the motion:

    T~ = T(q, qd) - T(q, 0) - dF/dq . qd,     V~ = V(q) - T(q, 0),

so that T~(q, 0) = 0. Only the part of a(q) = dL/dqd(q, 0) that is a gradient dF/dq is a gauge; the rest is a false
gyroscopic force and is reported as the remainder.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.evaluation.predictions import at_rest
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.gauge import Gauge
from repro.models.model import Model
from repro.models.terms import Terms

HARMONICS = 3


@dataclass(frozen=True)
class RestStates:
    """A fitted ensemble at rest at positions q (member, sample, n_q): what gauges are taken from, computed once."""

    model: Model
    parameters: np.ndarray
    system: System
    q: np.ndarray

    @cached_property
    def terms(self) -> Terms:
        """Predictions at rest."""
        return at_rest(self.model, self.parameters, self.q)

    @cached_property
    def gradients(self) -> np.ndarray:
        """The part dF/dq of dL/dqd(q, 0) that is a gradient, (member, sample, n_q) in kg m/s and kg m^2/s."""
        pairs = zip(self.q, self.terms.momentum, strict=True)
        return np.stack([_gradient_part(self.system, q, momentum) for q, momentum in pairs])

    @property
    def remainder(self) -> np.ndarray:
        """Mean over samples and components of |dL/dqd(q, 0) - dF/dq|, (member,) in kg m/s and kg m^2/s."""
        return np.asarray(np.abs(self.terms.momentum - self.gradients).mean((1, 2)))

    def anchor_error(self, canonical: bool) -> np.ndarray:
        """Learned less true energy of the upright rest, (member, 1) in J; canonical: V~ there, else T + V."""
        q = np.broadcast_to(self.system.at_rest(), (len(self.parameters), 1, self.system.n_q))
        upright = at_rest(self.model, self.parameters, q)
        energy = evaluate(dynamics_of(self.system).hamiltonian, self.system.at_rest(), np.zeros(self.system.n_q))[0]
        kinetic = -upright.kinetic if canonical else upright.kinetic
        return np.asarray(upright.potential + kinetic - energy)


def in_gauge(terms: Terms, rest: RestStates, qd: np.ndarray, gauge: Gauge) -> Terms:
    """The same predictions with T and V in a gauge: `raw`, with one known energy as `anchor`, `canonical`, or both.

    terms and qd (member, sample, n_q) are at the positions of `rest`. The anchor is the paper's (III-A.1): the energy
    of one state is known; here the upright rest, where H is V.
    """
    kinetic, potential = terms.kinetic, terms.potential
    if gauge.is_canonical:
        kinetic = kinetic - rest.terms.kinetic - (rest.gradients * qd).sum(-1)
        potential = potential - rest.terms.kinetic
    if gauge.is_anchored:
        potential = potential - rest.anchor_error(gauge.is_canonical)
    return replace(terms, kinetic=kinetic, potential=potential)


def _gradient_part(system: System, q: np.ndarray, field: np.ndarray) -> np.ndarray:
    """The gradient dF/dq, F linear plus trigonometric in the angles, closest to a field; q, field: (sample, n_q)."""
    angles = list(system.angles)
    # along a translation F is linear: its gradient there is the mean
    closest = np.broadcast_to(field.mean(axis=0), field.shape).copy()
    gradients = [np.broadcast_to(direction, (len(q), len(angles))) for direction in np.eye(len(angles))]
    for harmonics in product(range(-HARMONICS, HARMONICS + 1), repeat=len(angles)):
        leading = next((h for h in harmonics if h), 0)
        if leading <= 0:  # cos and sin of the mirrored combination are the same functions
            continue
        phase = q[:, angles] @ np.array(harmonics)
        gradients += [np.outer(-np.sin(phase), harmonics), np.outer(np.cos(phase), harmonics)]
    if angles:
        columns = np.array([gradient.ravel() for gradient in (*gradients, field[:, angles])]).T
        triangle = np.asarray(np.linalg.qr(columns, mode="r"))  # as good, and far fewer rows
        cutoff = len(columns) * np.finfo(float).eps
        solution, *_ = np.linalg.lstsq(triangle[:, :-1], triangle[:, -1], rcond=cutoff)
        closest[:, angles] = (columns[:, :-1] @ solution).reshape(len(q), -1)
    return closest
