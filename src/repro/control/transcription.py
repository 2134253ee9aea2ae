"""Problem (9) as a nonlinear programme: the layout of its variables and constraints, and their bounds.

Variables [x_0, v_0, x_1, v_1, ..., x_N] with v = [u, further unknowns]; constraints, stage by stage,
[x_{k+1} - F(x_k, v_k) | equalities | margins], the first stage followed by x_0 - x(t), the last with margins alone.
Parameters [x(t), goal, u_goal, weights of the model].
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from repro.control.interval import DEGREE, ELEMENTS, Interval, horizon_end, interval
from repro.control.optimal_control_problem import Discretisation, OptimalControlProblem
from repro.control.predictive_model import PredictiveModel


@dataclass(frozen=True)
class Transcription:
    """One problem for one model in one discretisation.

    substeps: steps of classical RK4 in an interval of shooting; even, so that one ends in the middle.
    """

    model: PredictiveModel
    problem: OptimalControlProblem
    discretisation: Discretisation
    substeps: int = 2

    @cached_property
    def interval(self) -> Interval:
        """Every stage but the last; they differ only in their data."""
        return interval(self.model, self.problem, self.discretisation, self.substeps)

    @cached_property
    def end(self) -> Interval:
        """The last stage."""
        return horizon_end(self.model, self.problem)

    @cached_property
    def roll_out(self) -> ca.Function:
        """(state (n_x,), inputs (n_u, n_intervals), shared parameters) -> states at the ends (n_x, n_intervals)."""
        stage = self.interval
        if self.discretisation != "shooting":  # otherwise its end is no explicit function of its start
            stage = interval(self.model, self.problem, "shooting", self.substeps)
        given = [stage.state, stage.inner, stage.parameters, stage.data]
        advance = ca.Function("advance", given, [stage.following], {"cse": True})
        state, inputs = ca.MX.sym("x", self.n_x), ca.MX.sym("u", self.n_u, self.n_intervals)
        shared = ca.MX.sym("shared", stage.parameters.numel())
        reached = [state]
        for length, u in zip(self.problem.intervals, ca.horzsplit(inputs), strict=True):
            reached.append(advance(reached[-1], u, shared, ca.DM([length, 0.0])))
        return ca.Function("roll_out", [state, inputs, shared], [ca.horzcat(*reached[1:])])

    @property
    def n_x(self) -> int:
        """Components of a state."""
        return 2 * self.model.n_q

    @property
    def n_u(self) -> int:
        """Inputs of an interval."""
        return self.model.n_u

    @property
    def n_v(self) -> int:
        """Inner variables of an interval, the inputs first."""
        return int(self.interval.inner.numel())

    @property
    def n_w(self) -> int:
        """Decision variables of an interval: its first state and its inner variables."""
        return self.n_x + self.n_v

    @property
    def n_intervals(self) -> int:
        """Intervals of the horizon."""
        return len(self.problem.intervals)

    @property
    def n_variables(self) -> int:
        """All decision variables."""
        return self.n_intervals * self.n_w + self.n_x

    @property
    def n_parameters(self) -> int:
        """Measured state, goal, its inputs, and the weights of the model."""
        return int(self.n_x + self.interval.parameters.numel())

    @property
    def n_rows(self) -> int:
        """Constraints of one interval."""
        return int(self.n_x + self.interval.equalities.numel() + self.interval.margins.numel())

    @property
    def rows(self) -> list[int]:
        """Constraints of each stage."""
        return [self.n_rows + self.n_x, *[self.n_rows] * (self.n_intervals - 1), self.end.margins.numel()]

    @property
    def data(self) -> np.ndarray:
        """Length of each interval, s, and 1 where the obstacle counts at its start, (2, n_intervals).

        It does not count at the first node: the measured state cannot be changed.
        """
        counts = np.arange(self.n_intervals) > 0
        return np.stack([self.problem.intervals, counts])

    def states(self, variables: np.ndarray) -> np.ndarray:
        """States at the nodes, (n_intervals + 1, n_x)."""
        return np.append(self._stages(variables)[:, : self.n_x], variables[None, -self.n_x :], axis=0)

    def inner(self, variables: np.ndarray) -> np.ndarray:
        """Inner variables, (n_intervals, n_v); the inputs first."""
        return self._stages(variables)[:, self.n_x :]

    def variables(self, states: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """The decision variables of states (n_intervals + 1, n_x) and inner variables (n_intervals, n_v)."""
        return np.append(np.concatenate([states[:-1], inner], axis=1).ravel(), states[-1])

    def parameters(self, state: np.ndarray, goal: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The parameters of one solution, (n_parameters,): measured state (n_x,), goal (n_q,), model weights."""
        return np.concatenate([state, goal, self.model.rest_inputs(goal, weights), weights])

    def guess(self, states: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """Decision variables from states (n_intervals + 1, n_x) and inputs (n_intervals, n_u), linear between nodes."""
        inner = [inputs]
        if self.discretisation == "collocation":
            steps = np.diff(states, axis=0)
            accelerations = steps[:, self.model.n_q :] / np.array(self.problem.intervals)[:, None]
            for element in range(ELEMENTS):
                shares = (element + np.array(ca.collocation_points(DEGREE, "radau"))) / ELEMENTS
                inner += [states[:-1] + share * steps for share in shares] + [accelerations] * DEGREE
        return self.variables(states, np.concatenate(inner, axis=1))

    def bounds(self) -> dict[str, np.ndarray]:
        """Bounds of variables (lbx, ubx) and constraints (lbg, ubg)."""
        most = np.full((self.n_intervals + 1, self.n_x), np.inf)
        if self.problem.speed_limit is not None:
            most[1:, self.model.n_q :] = self.problem.speed_limit
        inner = np.full((self.n_intervals, self.n_v), np.inf)
        inner[:, : self.n_u] = self.problem.force_limit
        ubx = self.variables(most, inner)
        n_margins = self.interval.margins.numel()
        free = np.repeat([0.0, np.inf], [self.n_rows - n_margins, n_margins])
        ubg = np.concatenate(
            [free, np.zeros(self.n_x), *[free] * (self.n_intervals - 1), np.full(self.rows[-1], np.inf)]
        )
        lbg = np.zeros_like(ubg)
        at_start = self.end.margins.numel()  # margins of the measured state, which cannot be changed
        first = self.n_rows - n_margins
        lbg[first : first + at_start] = -np.inf
        return {"lbx": -ubx, "ubx": ubx, "lbg": lbg, "ubg": ubg}

    def _stages(self, variables: np.ndarray) -> np.ndarray:
        return variables[: -self.n_x].reshape(self.n_intervals, self.n_w)
