"""The cost of problem (9) and the margins of its obstacle, at the nodes and at the middle of an interval."""

from dataclasses import dataclass
from typing import Any, assert_never

import casadi as ca

from repro.control.geometry import distances_squared
from repro.control.matrix_network import is_wide
from repro.control.optimal_control_problem import NodeWeights, OptimalControlProblem
from repro.control.predictive_model import PredictiveModel

Expression = Any  # casadi.SX, or casadi.MX where the model is large


@dataclass(frozen=True)
class HorizonCost:
    """Cost and margins of a problem, with the energies of a model.

    Symbols: state x = [q, qd] (2 n_q,), force f, parameters p = [x_des, weights of the model], data d = [length of the
    interval in s, 1 where the obstacle counts at its start (0 at the first node)]. Costs in J, margins in m^2.
    """

    model: PredictiveModel
    problem: OptimalControlProblem

    @property
    def kind(self) -> Any:
        """Scalar expressions, or matrix expressions for a wide network."""
        return ca.MX if is_wide(self.model.model) else ca.SX

    def symbols(self, kind: Any) -> tuple[Expression, Expression, Expression, Expression]:
        """State, force, parameters and data."""
        state, force = kind.sym("x", 2 * self.model.n_q), kind.sym("f")
        return state, force, kind.sym("p", 1 + self.model.model.n_parameters), kind.sym("d", 2)

    def start(self) -> ca.Function:
        """(x, f, p, d) -> cost of an interval except for its middle, and margins at its start."""
        state, force, parameters, data = self.symbols(self.kind)
        cost = data[0] / self.problem.time_step * self._cost(self.problem.stage_cost, state, force, parameters)
        penalty, margins = self._obstacle(state)
        return ca.Function("node", [state, force, parameters, data], [cost + data[1] * penalty, margins])

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
        return self._cost(self.problem.terminal_cost, state, self.kind(0), parameters) + penalty, margins

    def _cost(self, weights: NodeWeights, state: Expression, force: Expression, parameters: Expression) -> Expression:
        n_q = self.model.n_q
        q, qd = state[:n_q], state[n_q:]
        cost = weights.position * (q[0] - parameters[0]) ** 2 + weights.rates * ca.sumsqr(qd) + weights.force * force**2
        if weights.kinetic or weights.potential:
            kinetic, potential = self.model.energy(state, parameters[1:])
            cost += weights.kinetic * kinetic + weights.potential * self.model.potential_cost(potential)
        if weights.angle:
            system = self.model.system
            cost += weights.angle * sum(self._angle_error(q[i] - float(system.at_rest()[i])) for i in system.angles)
        return cost

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
        points = self.model.system.body_points(ca.vertsplit(state[: self.model.n_q]), ca)
        distances = ca.vertcat(*distances_squared(points, obstacle.centre, ca))
        if obstacle.constraint:
            return nothing[0], distances - obstacle.clearance_squared
        return obstacle.weight * ca.sumsqr(ca.fmax(obstacle.clearance_squared - distances, 0)), nothing[1]
