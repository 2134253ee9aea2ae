"""Interconnection of sub-models through power-conserving ports: H is the sum of theirs, and so is the dissipation."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.models.context import SubModel
from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions, Model

LEAST_SHARE = 0.1  # of the inertia that the data suggest, for the start of the rest
PLACES = 500  # samples at which the inertia of a part is looked at

Place = Callable[[casadi.SX], casadi.SX]


@dataclass(frozen=True)
class Joined:
    """A sub-model, and its coordinates (n_i,) as a function of those of the whole (n_q,)."""

    model: Model
    place: Place


class Interconnection(ExpressionModel):
    """Sub-models whose coordinates q_i = place_i(q) are those of one system.

    Velocities go down by A_i = dq_i/dq and forces come back by A_i', so that no power is lost or made between them:
    the graph of the skew map [0 -A'; A 0], a Dirac structure. Then

        T = sum T_i(q_i, A_i qd),   V = sum V_i(q_i),   friction = sum A_i' friction_i(q_i, A_i qd).

    parameters: those of the parts, in order. `trained` (member, n_trained) are upstream weights of the first parts;
    a fit starts from them, and does not change them where they are `frozen`.
    """

    def __init__(
        self, parts: Sequence[Joined], n_q: int, trained: np.ndarray | None = None, frozen: bool = True
    ) -> None:
        self.parts, self.n_q = tuple(parts), n_q
        self.trained = trained
        if trained is not None:
            self.upstream = slice(0, trained.shape[1])
            self.fixed = self.upstream if frozen else slice(0, 0)
        ends = [0, *accumulate(part.model.n_parameters for part in self.parts)]
        self.slices = [slice(start, stop) for start, stop in pairwise(ends)]

    @property
    def n_parameters(self) -> int:
        """Number of weights of one member."""
        return self.slices[-1].stop

    @property
    def coefficient_names(self) -> tuple[str, ...]:
        """Names of the parts' coefficients, in order."""
        return tuple(name for part in self.parts for name in part.model.coefficient_names)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """What the parts bring along, and the start of the others; for another number of members all is drawn."""
        drawn = np.concatenate([part.model.initial(generators) for part in self.parts], axis=1)
        if self.trained is not None and len(self.trained) == len(generators):
            drawn[:, self.upstream] = self.trained
        return drawn

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """The sums of the parts' T and V."""
        parts = self.part_energies(q, qd, parameters)
        kinetic, potential = casadi.SX(0), casadi.SX(0)
        for part in parts:
            kinetic, potential = kinetic + part.kinetic, potential + part.potential
        return EnergyExpressions(kinetic, potential)

    def part_energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> list[EnergyExpressions]:
        """T_i(q_i, A_i qd) and V_i(q_i), in order."""
        placed = [(part, part.place(q), weights) for part, weights in zip(self.parts, self.slices, strict=True)]
        return [
            part.model.energies(place, casadi.jtimes(place, q, qd), parameters[weights])
            for part, place, weights in placed
        ]

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """The parts' friction, brought back to the coordinates of the whole."""
        total = casadi.SX.zeros(self.n_q)
        for part, weights in zip(self.parts, self.slices, strict=True):
            place = part.place(q)
            below = casadi.jacobian(place, q)
            own, rates = (casadi.SX.sym(name, part.model.n_q) for name in ("q", "qd"))
            force = part.model.friction(own, rates, parameters[weights])
            total += below.T @ casadi.substitute([force], [own, rates], [place, below @ qd])[0]
        return total


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
