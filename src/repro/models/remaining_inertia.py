"""A trained sub-model inside a larger one: H_I = H_S + H_R, H_R of all coordinates (section IV, Proposition 1)."""

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.models.context import SubModel

LEAST_SHARE = 0.1  # of the inertia that the data suggest, for the start of the rest
PLACES = 500  # samples at which the inertia of a part is looked at


def mean_inertia(part: SubModel, q: np.ndarray) -> np.ndarray:
    """Diagonal of the part's mass matrix (n_i,), the mean over its members and over places q (member, sample, n_q)."""
    model = part.model
    place, rates = casadi.SX.sym("q", model.n_q), casadi.SX.sym("qd", model.n_q)
    weights = casadi.SX.sym("weights", model.n_parameters)
    mass = casadi.jacobian(model.momentum(place, rates, weights), rates)
    diagonal = casadi.Function("inertia", [place, rates, weights], [casadi.densify(casadi.diag(mass))])
    places = q.reshape(-1, q.shape[-1])[:PLACES, : model.n_q]
    inertia = [evaluate(diagonal, places, 0 * places, member) for member in part.parameters]
    mean: np.ndarray = np.mean(inertia, axis=(0, 1))
    return mean


def remaining_scale(velocity_scale: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """Scale of the velocities (n_q,) of a rest that starts as what is left of the inertia, M = diag(scale^-2).

    The data suggest diag(velocity_scale^-2), as much energy for every coordinate; `inertia` (n_i,) of the first
    coordinates is there already.
    """
    suggested = velocity_scale**-2.0
    left = suggested - np.pad(inertia, (0, len(suggested) - len(inertia)))
    scale: np.ndarray = np.maximum(left, LEAST_SHARE * suggested) ** -0.5
    return scale
