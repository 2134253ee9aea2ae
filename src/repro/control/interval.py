"""One interval of the horizon: its motion as equations between decision variables, and its cost."""

from dataclasses import dataclass
from typing import Any, assert_never

import casadi as ca
import numpy as np

from repro.control.horizon_cost import Expression, HorizonCost
from repro.control.matrix_network import is_wide
from repro.control.optimal_control_problem import Discretisation, OptimalControlProblem
from repro.control.predictive_model import PredictiveModel
from repro.mechanics.runge_kutta import rk4_step

LARGEST_INLINE = 400  # instructions of the model's derivative
DEGREE, ELEMENTS = 2, 2  # Gauss-Radau, V-A.1


@dataclass(frozen=True)
class Interval:
    """Symbols and expressions of one interval, or of the last node (no inner variables, no following state).

    state       x = [q, qd] at its start
    inner       [u, further unknowns]
    parameters  [goal, u_goal, weights of the model]
    data        [length in s, 1 where the obstacle counts at the start (0 at the first node)]
    following   x at its end
    equalities  zero along a motion
    margins     must not be negative where the obstacle is a constraint
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


def interval(
    model: PredictiveModel, problem: OptimalControlProblem, discretisation: Discretisation, substeps: int
) -> Interval:
    """One interval under constant inputs: explicit RK4 in substeps, or collocation with (7b) in algebraic form.

    A small model is written out as scalar expressions. A large one stays a function that is called, so that the code
    of its derivatives is generated once and not for every place where it is evaluated.
    """
    small = not is_wide(model.model) and model.derivative.n_instructions() <= LARGEST_INLINE
    kind = ca.SX if small else ca.MX
    costs = HorizonCost(model, problem)
    state, u, parameters, data = costs.symbols(kind)
    weights, length = parameters[costs.n_goal :], data[0]
    match discretisation:
        case "shooting":
            motion = _shoot(model, state, u, weights, length, substeps)
        case "collocation":
            motion = _collocate(model, state, u, weights, length)
        case other:
            assert_never(other)
    cost, margins = costs.start()(state, u, parameters, data)
    penalty, further = costs.middle(motion.middle)
    cost += penalty
    margins = ca.vertcat(margins, further)
    return Interval(
        state,
        ca.vertcat(u, *motion.inner),
        parameters,
        data,
        motion.following,
        ca.vertcat(kind(0, 1), *motion.equalities),
        margins,
        cost,
    )


def horizon_end(model: PredictiveModel, problem: OptimalControlProblem) -> Interval:
    """The last node."""
    costs = HorizonCost(model, problem)
    state, _, parameters, data = costs.symbols(costs.kind)
    cost, margins = costs.end(state, parameters)
    empty = costs.kind(0, 1)
    return Interval(state, empty, parameters, data, empty, empty, margins, cost)


def _shoot(
    model: PredictiveModel, state: Expression, u: Expression, weights: Expression, length: Expression, substeps: int
) -> _Motion:
    reached, h, derivative = [state], length / substeps, model.derivative
    for _ in range(substeps):
        reached.append(rk4_step(lambda x: derivative(x, u, weights), reached[-1], h))
    return _Motion(reached[-1], reached[substeps // 2], [], [])


def _collocate(
    model: PredictiveModel, state: Expression, u: Expression, weights: Expression, length: Expression
) -> _Motion:
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
    return _Motion(starts[-1], starts[ELEMENTS // 2], inner, equalities)
