"""Interconnection of sub-models through power-conserving ports: H is the sum of theirs, and so is the dissipation."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi
import numpy as np

from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions, Model, consecutive

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
        self.slices = consecutive(*(part.model.n_parameters for part in self.parts))
        self.n_parameters = self.slices[-1].stop

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
        parts, zero = self.part_energies(q, qd, parameters), casadi.SX(0)
        return EnergyExpressions(
            sum((each.kinetic for each in parts), zero), sum((each.potential for each in parts), zero)
        )

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
