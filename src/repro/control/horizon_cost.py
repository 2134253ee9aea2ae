"""The cost of problem (9) and the margins of its obstacle, at the nodes and at the middle of an interval."""

from dataclasses import dataclass
from typing import Any, assert_never

import casadi as ca

from repro.control.geometry import distances_squared
from repro.control.matrix_network import is_wide
from repro.control.optimal_control_problem import NodeWeights, OptimalControlProblem, by_name
from repro.control.predictive_model import PredictiveModel

Expression = Any  # casadi.SX, or casadi.MX where the model is large


@dataclass(frozen=True)
class HorizonCost:
    """Cost and margins of a problem, with the energies of a model.

    Symbols: state x = [q, qd] (2 n_q,), inputs u (n_u,), parameters p = [goal (n_q,), u_goal (n_u,), weights of the
    model], data d = [length of the interval in s, 1 where the obstacle counts at its start (0 at the first node)].
    Costs in J, margins in m^2.
    """

    model: PredictiveModel
    problem: OptimalControlProblem

    @property
    def kind(self) -> Any:
        """Scalar expressions, or matrix expressions for a wide network."""
        return ca.MX if is_wide(self.model.model) else ca.SX

    def symbols(self, kind: Any) -> tuple[Expression, Expression, Expression, Expression]:
        """State, inputs, parameters and data."""
        state, u = kind.sym("x", 2 * self.model.n_q), kind.sym("u", self.model.n_u)
        return state, u, kind.sym("p", self.n_goal + self.model.model.n_parameters), kind.sym("d", 2)

    @property
    def n_goal(self) -> int:
        """Number of parameters before the weights."""
        return self.model.n_q + self.model.n_u

    def start(self) -> ca.Function:
        """(x, u, p, d) -> cost of an interval except for its middle, and margins at its start."""
        state, u, parameters, data = self.symbols(self.kind)
        cost = data[0] / self.problem.time_step * self._cost(self.problem.stage_cost, state, u, parameters)
        penalty, margins = self._obstacle(state)
        return ca.Function("node", [state, u, parameters, data], [cost + data[1] * penalty, margins])

    def middle(self, state: Expression) -> tuple[Expression, Expression]:
        """Penalty and margins of the state at the middle of an interval, where the obstacle counts there."""
        if self.problem.obstacle is None or not self.problem.obstacle.midpoints:
            return type(state)(0), type(state)(0, 1)
        scalar = ca.SX.sym("x", 2 * self.model.n_q)
        penalty, margins = ca.Function("middle", [scalar], [*self._obstacle(scalar)])(state)
        return penalty, margins

    def end(self, state: Expression, parameters: Expression) -> tuple[Expression, Expression]:
        """Cost and margins of the last node."""
        penalty, margins = self._obstacle(state)
        return self._cost(self.problem.terminal_cost, state, None, parameters) + penalty, margins

    def _cost(
        self, weights: NodeWeights, state: Expression, u: Expression | None, parameters: Expression
    ) -> Expression:
        n_q, system = self.model.n_q, self.model.system
        q, qd, goal, u_goal = state[:n_q], state[n_q:], parameters[:n_q], parameters[n_q : self.n_goal]
        located = [coordinate.cyclic or not coordinate.is_angle for coordinate in system.coordinates]
        names = [coordinate.name for coordinate in system.coordinates]
        cost = _squares(by_name(weights.position, names, located), q - goal) + weights.rates * ca.sumsqr(qd)
        if u is not None:
            inputs = [each.name for each in system.inputs]
            cost += _squares(by_name(weights.force, inputs, [True] * len(inputs)), u - u_goal)
        if weights.kinetic or weights.potential:
            kinetic, potential = self.model.energy(state, parameters[self.n_goal :])
            cost += weights.kinetic * kinetic + weights.potential * self._potential_cost(potential, parameters)
        if weights.angle:
            errors = [self._angle_error(q[i] - goal[i]) for i, moved in enumerate(located) if not moved]
            cost += weights.angle * sum(errors)
        return cost

    def _potential_cost(self, potential: Expression, parameters: Expression) -> Expression:
        match self.problem.potential_goal:
            case "maximum":
                return self.model.potential_cost(potential)
            case "minimum":
                return potential
            case "goal":
                rest = ca.vertcat(parameters[: self.model.n_q], ca.DM.zeros(self.model.n_q))
                return (potential - self.model.energy(rest, parameters[self.n_goal :])[1]) ** 2
            case other:
                assert_never(other)

    def _angle_error(self, error: Expression) -> Expression:
        match self.problem.angle_error:
            case "cosine":
                return 1 - ca.cos(error)
            case "square":
                return error**2
            case other:
                assert_never(other)

    def _obstacle(self, state: Expression) -> tuple[Expression, Expression]:
        """Penalty, J, and margins, m^2, of the obstacle: one of the two is zero or empty."""
        obstacle = self.problem.obstacle
        nothing = type(state)(0), type(state)(0, 1)
        if obstacle is None:
            return nothing
        shapes = self.model.system.shapes(ca.vertsplit(state[: self.model.n_q]), ca)
        distances = ca.vertcat(*distances_squared(shapes, obstacle.centre, ca))
        if obstacle.constraint:
            return nothing[0], distances - obstacle.clearance_squared
        return obstacle.weight * ca.sumsqr(ca.fmax(obstacle.clearance_squared - distances, 0)), nothing[1]


def _squares(weights: list[float], errors: Expression) -> Expression:
    """The weighted sum of squared errors (n,)."""
    return sum((weight * errors[i] ** 2 for i, weight in enumerate(weights) if weight), type(errors)(0))
