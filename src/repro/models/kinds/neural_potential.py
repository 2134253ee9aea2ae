"""T = qd' M(q) qd / 2 with M = C C', and V a network of all positions: for bodies whose forces are not only weights."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import casadi
import numpy as np

from repro.mechanics.system import System
from repro.models.context import Context
from repro.models.damped import with_damping
from repro.models.expression import ExpressionModel
from repro.models.model import EnergyExpressions, Model, consecutive
from repro.models.model_options import Activation, Damping, ModelOptions
from repro.models.network import Network
from repro.plugins.options import Count


@dataclass(frozen=True)
class Options(ModelOptions):
    """Options of model=neural_potential: what each is stands in conf/model/neural_potential.yaml."""

    joinable: ClassVar[bool] = True

    hidden: tuple[Count, ...] = (8,)
    potential_hidden: tuple[Count, ...] = (8,)
    inertia: Literal["angles", "positions"] = "angles"
    activation: Activation = "tanh"
    damping: Damping = "none"

    def system_problem(self, system: System) -> str | None:
        """An inertia that depends on a translation needs model.inertia=positions."""
        from repro.mechanics.derive import dynamics_of

        seen = dynamics_of(system).mass_matrix.jac_sparsity(0, 0).get_col()
        hidden = [c.name for i, c in enumerate(system.coordinates) if i in seen and not c.is_angle]
        if hidden and self.inertia == "angles":
            return (
                f"model.inertia = 'angles': the inertia of system={system.name} depends on {', '.join(hidden)}; "
                "use model.inertia=positions"
            )
        return super().system_problem(system)


class NeuralPotential(ExpressionModel):
    """M from a network of the angles, V from one of all positions, and V = 0 where all of these are 0.

    C (n_q, rank) sees the angles' {cos, sin} and the translations `moved`, V these and all translations. Where it sees
    nothing C is constant. Velocities are divided by `velocity_scale`, translations by `position_scale`, both (n_q,).
    Both networks have a linear path. parameters: [weights of C | weights of V].
    """

    def __init__(
        self,
        velocity_scale: np.ndarray,
        position_scale: np.ndarray,
        angles: Sequence[int],
        options: Options,
        moved: Sequence[int] = (),
    ) -> None:
        self.n_q, self.angles, self.moved = len(velocity_scale), tuple(angles), tuple(moved)
        inputs = 2 * len(self.angles)
        varies = bool(self.angles or self.moved)
        self.rank = self.n_q + 2 if varies else self.n_q
        self.velocity_scale = np.asarray(velocity_scale, dtype=float)
        self.position_scale = np.asarray(position_scale, dtype=float)
        units, activation = options.hidden if varies else (), options.activation
        self.factor = Network(inputs + len(self.moved), units, self.n_q * self.rank, activation, varies)
        positions = inputs + self.n_q - len(self.angles)
        self.potential = Network(positions, options.potential_hidden, 1, activation, True)
        self.factor_slice, self.potential_slice = consecutive(self.factor.n_parameters, self.potential.n_parameters)
        self.n_parameters = self.potential_slice.stop

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights, a tenth of them for C; its biases make M start as diag(velocity_scale^-2)."""
        factors = 0.1 * self.factor.initial(generators)
        end = self.factor.n_parameters - self.factor.n_in * self.factor.n_out * int(self.factor.skip)
        factors[:, end - self.factor.n_out : end] = np.eye(self.n_q, self.rank).ravel()
        return np.concatenate([factors, self.potential.initial(generators)], axis=1)

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T and V as CasADi expressions."""
        at_rest = self._potential(casadi.SX.zeros(self.n_q), parameters)
        seen = casadi.vertcat(casadi.SX(0, 1), *self._turns(q), *self._places(q, self.moved))
        entries = self.factor.expression(parameters[self.factor_slice], seen)
        u = casadi.reshape(entries, self.rank, self.n_q) @ (qd / casadi.DM(self.velocity_scale))
        return EnergyExpressions(0.5 * casadi.dot(u, u), self._potential(q, parameters) - at_rest)

    def _potential(self, q: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        places = self._places(q, [i for i in range(self.n_q) if i not in self.angles])
        return self.potential.expression(parameters[self.potential_slice], casadi.vertcat(*self._turns(q), *places))

    def _places(self, q: casadi.SX, translations: Sequence[int]) -> list[casadi.SX]:
        return [q[i] / self.position_scale[i] for i in translations]

    def _turns(self, q: casadi.SX) -> list[casadi.SX]:
        return [turn for angle in self.angles for turn in (casadi.cos(q[angle]), casadi.sin(q[angle]))]


def build(context: Context, options: Options) -> Model:
    """The model, beside friction where chosen; V is a function of all positions, of cyclic ones too."""
    model = NeuralPotential(
        context.velocity_scale,
        context.position_scale,
        [i for i, coordinate in enumerate(context.coordinates) if coordinate.is_angle],
        options,
        [i for i, _ in context.positions.translations] if options.inertia == "positions" else [],
    )
    return with_damping(model, options.damping, context.positions)
