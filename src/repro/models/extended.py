"""A trained sub-model inside a larger one: H_I = H_S + H_R, H_R of all coordinates (section IV, Proposition 1)."""

from typing import Literal

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.models.context import Part, Setting
from repro.models.interconnection import Interconnection, Joined
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.network import Activation
from repro.models.structured import Structured

LEAST_SHARE = 0.1  # of the inertia that the data suggest, for the start of the rest
PLACES = 500  # samples at which the inertia of a part is looked at


def build(
    setting: Setting,
    *,
    parts: list[str],
    frozen: bool = True,
    rest: Literal["structured", "basis"] = "structured",
    hidden: list[int],
    rank: int | None = None,
    activation: Activation = "tanh",
    skip: bool = True,
) -> Interconnection:
    """The model of this file for a setting; the keywords are its options in conf/model.

    The one part is of the first coordinates, as a cart with one rod is of a double pendulum; UserError otherwise.
    """
    if len(setting.parts) != 1 or setting.parts[0].model.n_q >= setting.n_q:
        raise UserError(f"model.parts = {parts}: give one sub-model of fewer coordinates than {setting.n_q}")
    (part,) = setting.parts
    own = part.model.n_q
    other: Model
    if rest == "basis":
        other = Lagrangian(setting.basis, setting.n_q, hidden=hidden, activation=activation)
    else:
        scale = remaining_scale(setting.velocity_scale, mean_inertia(part, setting.q))
        other = Structured(setting.n_q, scale, hidden=hidden, rank=rank, activation=activation, skip=skip)
    joined = [Joined(part.model, lambda q: q[:own]), Joined(other, lambda q: q)]
    return Interconnection(joined, setting.n_q, part.parameters, frozen)


def mean_inertia(part: Part, q: np.ndarray) -> np.ndarray:
    """Diagonal of the part's mass matrix (n_i,), the mean over its members and over places q (member, sample, n_q)."""
    model = part.model
    place, rates = casadi.SX.sym("q", model.n_q), casadi.SX.sym("qd", model.n_q)
    weights = casadi.SX.sym("weights", model.n_parameters)
    mass = casadi.jacobian(model.momentum(place, rates, weights), rates)
    diagonal = casadi.Function("inertia", [place, rates, weights], [casadi.densify(casadi.diag(mass))])
    places = q.reshape(-1, q.shape[-1])[:PLACES, : model.n_q]
    return np.mean([evaluate(diagonal, places, 0 * places, member) for member in part.parameters], axis=(0, 1))


def remaining_scale(velocity_scale: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """Scale of the velocities (n_q,) of a rest that starts as what is left of the inertia, M = diag(scale^-2).

    The data suggest diag(velocity_scale^-2), as much energy for every coordinate; `inertia` (n_i,) of the first
    coordinates is there already.
    """
    suggested = velocity_scale**-2.0
    left = suggested - np.pad(inertia, (0, len(suggested) - len(inertia)))
    return np.maximum(left, LEAST_SHARE * suggested) ** -0.5
