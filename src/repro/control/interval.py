"""One interval of the horizon: its motion as equations between decision variables, its cost and its margins."""

from dataclasses import dataclass
from typing import Any, assert_never

import casadi as ca
import numpy as np

from repro.control.geometry import distances_squared
from repro.control.optimal_control_problem import Discretisation, NodeWeights, OptimalControlProblem, by_name
from repro.control.predictive_model import PredictiveModel
from repro.mechanics.runge_kutta import rk4_step

LARGEST_INLINE = 400  # instructions of the model's derivative
DEGREE, ELEMENTS = 2, 2  # Gauss-Radau, V-A.1
Expression = Any  # casadi.SX, or casadi.MX where the model is large
Motion = tuple[Expression, Expression, list[Any], list[Any]]  # state at the end and in the middle, unknowns, equations


@dataclass(frozen=True)
class HorizonCost:
    """Cost and margins of a problem, with the energies of a model.

    Symbols: state x = [q, qd] (2 n_q,), inputs u (n_u,), parameters p = [goal (n_q,), u_goal (n_u,), weights of the
    model], data d = [length of the interval in s, 1 where the obstacle counts at its start (0 at the first node)].
    Costs in J, margins in m^2.
    """

    model: PredictiveModel
    problem: OptimalControlProblem

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
        state, u, parameters, data = self.symbols(self.model.kind)
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
            errors = [q[i] - goal[i] for i, moved in enumerate(located) if not moved]
            squared = self.problem.angle_error == "square"
            cost += weights.angle * sum(error**2 if squared else 1 - ca.cos(error) for error in errors)
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


@dataclass(frozen=True)
class Interval:
    """Symbols and expressions of one interval, or of the last node (no inner variables, no following state)."""

    state: Expression  # x = [q, qd] at its start
    inner: Expression  # [u, further unknowns]
    parameters: Expression  # [goal, u_goal, weights of the model]
    data: Expression  # [length in s, 1 where the obstacle counts at the start (0 at the first node)]
    following: Expression  # x at its end
    equalities: Expression  # zero along a motion
    margins: Expression  # must not be negative where the obstacle is a constraint
    cost: Expression  # J


def interval(
    model: PredictiveModel, problem: OptimalControlProblem, discretisation: Discretisation, substeps: int
) -> Interval:
    """One interval under constant inputs: explicit RK4 in substeps, or collocation with (7b) in algebraic form.

    A small model is written out as scalar expressions. A large one stays a function that is called, so that the code
    of its derivatives is generated once and not for every place where it is evaluated.
    """
    kind = model.kind if model.derivative.n_instructions() <= LARGEST_INLINE else ca.MX
    costs = HorizonCost(model, problem)
    state, u, parameters, data = costs.symbols(kind)
    weights, length = parameters[costs.n_goal :], data[0]
    match discretisation:
        case "shooting":
            following, middle, inner, equalities = _shoot(model, state, u, weights, length, substeps)
        case "collocation":
            following, middle, inner, equalities = _collocate(model, state, u, weights, length)
        case other:
            assert_never(other)
    cost, margins = costs.start()(state, u, parameters, data)
    penalty, further = costs.middle(middle)
    unknowns, rows = ca.vertcat(u, *inner), ca.vertcat(kind(0, 1), *equalities)
    margins = ca.vertcat(margins, further)
    return Interval(state, unknowns, parameters, data, following, rows, margins, cost + penalty)


def horizon_end(model: PredictiveModel, problem: OptimalControlProblem) -> Interval:
    """The last node."""
    costs = HorizonCost(model, problem)
    state, _, parameters, data = costs.symbols(model.kind)
    cost, margins = costs.end(state, parameters)
    empty = model.kind(0, 1)
    return Interval(state, empty, parameters, data, empty, empty, margins, cost)


def _shoot(
    model: PredictiveModel, state: Expression, u: Expression, weights: Expression, length: Expression, substeps: int
) -> Motion:
    reached, h, derivative = [state], length / substeps, model.derivative
    for _ in range(substeps):
        reached.append(rk4_step(lambda x: derivative(x, u, weights), reached[-1], h))
    return reached[-1], reached[substeps // 2], [], []


def _collocate(
    model: PredictiveModel, state: Expression, u: Expression, weights: Expression, length: Expression
) -> Motion:
    n_q, symbol = model.n_q, type(state).sym
    rates = ca.DM(np.array(ca.collocation_coeff(ca.collocation_points(DEGREE, "radau"))[0]))
    h = length / ELEMENTS
    starts: list[Any] = [state]
    inner: list[Any] = []
    equalities: list[Any] = []
    for element in range(ELEMENTS):
        # Radau: the last point is the element's end
        points = [symbol(f"x{element}{j}", 2 * n_q) for j in range(DEGREE)]
        accelerations = [symbol(f"a{element}{j}", n_q) for j in range(DEGREE)]
        polynomial = ca.mtimes(ca.horzcat(starts[-1], *points), rates)
        for j, (x, qdd) in enumerate(zip(points, accelerations, strict=True)):
            equalities += [
                polynomial[:, j] - h * ca.vertcat(x[n_q:], qdd),
                model.inverse(x, qdd, u, weights),
            ]
        inner += [*points, *accelerations]
        starts.append(points[-1])
    return starts[-1], starts[ELEMENTS // 2], inner, equalities
