"""A trained sub-model inside a larger one: H_I = H_S + H_R, H_R of all coordinates (section IV, Proposition 1)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.errors import UserError
from repro.models.context import Context, SubModel
from repro.models.interconnection import Interconnection, Joined
from repro.models.kinds import structured
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.models.model_options import Activation, ModelOptions
from repro.plugins.options import Count

LEAST_SHARE = 0.1  # of the inertia that the data suggest, for the start of the rest
PLACES = 500  # samples at which the inertia of a part is looked at


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=extended: what each is stands in conf/model/extended.yaml."""

    parts: tuple[str, ...] = ("cart_rod",)
    frozen: bool = True
    rest: Literal["structured", "basis"] = "structured"
    hidden: tuple[Count, ...] = (8,)
    rank: Count | None = None
    activation: Activation = "tanh"
    skip: bool = True

    @property
    def uses_basis(self) -> bool:
        """Whether the rest is made of the features of the basis."""
        return self.rest == "basis"

    def parts_problem(self, n_q: int, part_sizes: Sequence[int]) -> str | None:
        """One sub-model of the first coordinates, as a cart with one rod is of a double pendulum."""
        if len(part_sizes) == 1 and part_sizes[0] < n_q:
            return None
        return f"model.parts = {list(self.parts)}: give one sub-model of fewer coordinates than the {n_q} of the system"

    def is_linear(self, basis_is_linear: bool) -> bool:
        """What is fitted beside a frozen part is the rest."""
        return self.frozen and self.rest == "basis" and basis_is_linear


def build(context: Context, options: Options) -> Model:
    """The joined model; UserError unless the one part is of the first coordinates, as a cart with one rod is."""
    if problem := options.parts_problem(context.n_q, [part.model.n_q for part in context.parts]):
        raise UserError(problem)
    (part,) = context.parts
    own, hidden, activation = part.model.n_q, options.hidden, options.activation
    rest: Model
    if options.rest == "basis":
        rest = Lagrangian(context.basis, context.n_q, hidden=hidden, activation=activation)
    else:
        scale = remaining_scale(context.velocity_scale, mean_inertia(part, context.q))
        chosen = structured.Options(
            hidden=hidden, rank=options.rank, activation=activation, skip=options.skip, potential="cosines"
        )
        rest = structured.Structured(context.n_q, scale, chosen, context.positions)
    joined = [Joined(part.model, lambda q: q[:own]), Joined(rest, lambda q: q)]
    return Interconnection(joined, context.n_q, part.parameters, options.frozen)


def mean_inertia(part: SubModel, q: np.ndarray) -> np.ndarray:
    """Diagonal of the part's mass matrix (n_i,), the mean over its members and over places q (member, sample, n_q)."""
    model = part.model
    symbols = model.symbols("q", "qd")
    diagonal = casadi.Function("inertia", symbols, [casadi.densify(casadi.diag(model.mass_matrix(*symbols)))])
    places = q.reshape(-1, q.shape[-1])[:PLACES, : model.n_q]
    inertia = [evaluate(diagonal, places, 0 * places, member) for member in part.parameters]
    mean: np.ndarray = np.mean(inertia, axis=(0, 1))
    return mean


def remaining_scale(velocity_scale: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """Scale of the velocities (n_q,) of a rest that starts as what is left of the inertia, M = diag(scale^-2).

    The data suggest diag(velocity_scale^-2), as much energy for every coordinate; `inertia` (n_i,) is there already.
    """
    suggested = velocity_scale**-2.0
    left = suggested - np.pad(inertia, (0, len(suggested) - len(inertia)))
    scale: np.ndarray = np.maximum(left, LEAST_SHARE * suggested) ** -0.5
    return scale
