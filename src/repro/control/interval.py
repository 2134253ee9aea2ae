"""One interval of the horizon: its motion as equations between decision variables, and what it costs."""

from dataclasses import dataclass
from typing import Any, Literal

import casadi as ca
import numpy as np

from repro.control.geometry import distances_squared
from repro.control.matrix_network import is_wide
from repro.control.optimal_control_problem import Problem, Weights
from repro.control.point import Point
from repro.control.predictive_model import PredictiveModel
from repro.mechanics.runge_kutta import rk4_step

Discretisation = Literal["shooting", "collocation"]
Expression = Any  # casadi.SX, or casadi.MX where the model is large
LARGEST_INLINE = 400  # instructions of the model's derivative
DEGREE, ELEMENTS = 2, 2  # Gauss-Radau, V-A.1


@dataclass(frozen=True)
class Interval:
    """Symbols and expressions of one interval, or of the end of the horizon (no inner variables, nothing following).

    state       x = [q, qd] at its start
    inner       [f, further unknowns]
    parameters  [x_des, weights of the model]
    data        [length in s, 1 where the obstacle counts at the start (0 at the first node)]
    following   x at its end
    equalities  zero along a motion
    margins     non-negative where the hard obstacle is kept away from
    cost        J
    """

    state: Expression
    inner: Expression
    parameters: Expression
    data: Expression
    following: Expression
    equalities: Expression
    margins: Expression
    cost: Expression


@dataclass(frozen=True)
class _Motion:
    following: Expression
    middle: Expression
    inner: list[Any]
    equalities: list[Any]


def interval(model: PredictiveModel, problem: Problem, discretisation: Discretisation, substeps: int) -> Interval:
    """One interval under a force that is held: explicit RK4 in substeps, or collocation with (7b) in algebraic form.

    A small model is written out as scalar expressions; a large one stays a function that is called, so that the code
    of its derivatives is there once and not once for every place where it is evaluated.
    """
    small = not is_wide(model.model) and model.derivative.n_instructions() <= LARGEST_INLINE
    kind = ca.SX if small else ca.MX
    state, force, parameters, data = _symbols(model, kind)
    given = model, state, force, parameters[1:], data[0]
    motion = _shoot(*given, substeps) if discretisation == "shooting" else _collocate(*given)
    cost, margins = _node(model, problem)(state, force, parameters, data)
    if problem.obstacle is not None and problem.obstacle.midpoints:
        penalty, further = _middle(model, problem)(motion.middle)
        cost += penalty
        margins = ca.vertcat(margins, further)
    return Interval(
        state,
        ca.vertcat(force, *motion.inner),
        parameters,
        data,
        motion.following,
        ca.vertcat(kind(0, 1), *motion.equalities),
        margins,
        cost,
    )


def horizon_end(model: PredictiveModel, problem: Problem) -> Interval:
    """The last node."""
    kind = _kind_of_cost(model)
    state, _, parameters, data = _symbols(model, kind)
    penalty, margins = _keep_away(model, problem, state)
    cost = _cost(model, problem, problem.terminal, state, kind(0), parameters) + penalty
    none = kind(0, 1)
    return Interval(state, none, parameters, data, none, none, margins, cost)


def points(model: PredictiveModel, problem: Problem) -> tuple[Point, Point, Point]:
    """The start of an interval with its force, the middle of one, and the end of the horizon."""
    state, force, shared, data = _symbols(model, ca.SX)
    end = horizon_end(model, problem)
    nothing = (ca.SX(0), ca.SX(0, 1))
    has_middle = problem.obstacle is not None and problem.obstacle.midpoints
    return (
        Point("start", ca.vertcat(state, force), shared, data, *_node(model, problem)(state, force, shared, data)),
        Point("middle", state, shared, data, *(_keep_away(model, problem, state) if has_middle else nothing)),
        Point("end", end.state, end.parameters, end.data, end.cost, end.margins),
    )


def _symbols(model: PredictiveModel, kind: Any) -> tuple[Any, Any, Any, Any]:
    state, force = kind.sym("x", 2 * model.n_q), kind.sym("f")
    return state, force, kind.sym("p", 1 + model.model.n_parameters), kind.sym("d", 2)


def _kind_of_cost(model: PredictiveModel) -> Any:
    return ca.MX if is_wide(model.model) else ca.SX


def _node(model: PredictiveModel, problem: Problem) -> ca.Function:
    """(x, f, p, d) -> cost of the interval but for its middle, and margins at its start."""
    state, force, parameters, data = _symbols(model, _kind_of_cost(model))
    cost = data[0] / problem.time_step * _cost(model, problem, problem.running, state, force, parameters)
    penalty, margins = _keep_away(model, problem, state)
    return ca.Function("node", [state, force, parameters, data], [cost + data[1] * penalty, margins])


def _middle(model: PredictiveModel, problem: Problem) -> ca.Function:
    """x in the middle -> penalty and margins."""
    state = ca.SX.sym("x", 2 * model.n_q)
    return ca.Function("middle", [state], [*_keep_away(model, problem, state)])


def _cost(
    model: PredictiveModel,
    problem: Problem,
    weights: Weights,
    state: Expression,
    force: Expression,
    parameters: Expression,
) -> Expression:
    q, qd = state[: model.n_q], state[model.n_q :]
    cost = weights.position * (q[0] - parameters[0]) ** 2 + weights.rates * ca.sumsqr(qd) + weights.force * force**2
    if weights.kinetic or weights.potential:
        kinetic, potential = model.energy(state, parameters[1:])
        cost += weights.kinetic * kinetic + weights.potential * model.potential_cost(potential)
    if weights.angle:
        errors = [q[i] - float(model.system.upright[i]) for i in model.system.angles]
        each = [1 - ca.cos(error) if problem.angle_error == "cosine" else error**2 for error in errors]
        cost += weights.angle * sum(each)
    return cost


def _keep_away(model: PredictiveModel, problem: Problem, state: Expression) -> tuple[Expression, Expression]:
    """The penalty of a soft obstacle, J, and the margins of a hard one, m^2."""
    obstacle = problem.obstacle
    if obstacle is None:
        return type(state)(0), type(state)(0, 1)
    points = model.system.body_points(ca.vertsplit(state[: model.n_q]), ca)
    distances = ca.vertcat(*distances_squared(points, obstacle.centre, ca))
    if obstacle.hard:
        return type(state)(0), distances - obstacle.least_squared
    return obstacle.weight * ca.sumsqr(ca.fmax(obstacle.least_squared - distances, 0)), type(state)(0, 1)


def _shoot(
    model: PredictiveModel, state: Expression, force: Expression, weights: Expression, length: Expression, substeps: int
) -> _Motion:
    reached, h, derivative = [state], length / substeps, model.derivative
    for _ in range(substeps):
        reached.append(rk4_step(lambda x: derivative(x, force, weights), reached[-1], h))
    return _Motion(reached[-1], reached[substeps // 2], [], [])


def _collocate(
    model: PredictiveModel, state: Expression, force: Expression, weights: Expression, length: Expression
) -> _Motion:
    n_q, symbol = model.n_q, type(state).sym
    slopes = ca.DM(np.array(ca.collocation_coeff(ca.collocation_points(DEGREE, "radau"))[0]))
    h = length / ELEMENTS
    starts: list[Any] = [state]
    inner: list[Any] = []
    equalities: list[Any] = []
    for element in range(ELEMENTS):
        # Radau: the last point is the element's end
        points = [symbol(f"x{element}{j}", 2 * n_q) for j in range(DEGREE)]
        accelerations = [symbol(f"a{element}{j}", n_q) for j in range(DEGREE)]
        polynomial = ca.mtimes(ca.horzcat(starts[-1], *points), slopes)
        for j, (x, qdd) in enumerate(zip(points, accelerations, strict=True)):
            equalities += [
                polynomial[:, j] - h * ca.vertcat(x[n_q:], qdd),
                model.inverse(x, qdd, force, weights),
            ]
        inner += [*points, *accelerations]
        starts.append(points[-1])
    return _Motion(starts[-1], starts[ELEMENTS // 2], inner, equalities)
