"""Model predictive control: problem (9), solved at every step from the shifted plan of the previous step."""

from dataclasses import dataclass

import numpy as np

from repro.control.controller import Controller, ControlStep
from repro.control.nonlinear_solver import Solution, Solver
from repro.control.transcription import Transcription

GOOD_ENOUGH = 1e-3  # violation of the constraints up to which a solution counts without convergence
PASSABLE = 0.1  # violation up to which the better of two solutions is preferred to the last plan
NEAR_GOAL = np.deg2rad(30)  # of every angle
DIVERGED = 1e3  # a predicted state beyond is not used as a guess
ROUNDING = 1e-9  # s, of sums of time steps


@dataclass
class Plan:
    """The last good solution: states (nodes, 2 n_q), inputs (nodes - 1, n_u), and its age in steps."""

    states: np.ndarray
    inputs: np.ndarray
    age: int = 0


class PredictiveController(Controller):
    """Solves from the shifted plan, then from a roll-out of the shifted inputs; if both fail it follows the last plan.

    A solution counts if it converged, or if its constraints hold to 1e-3; after the second try the better of both
    counts if they hold to 0.1, and becomes the plan. `ControlStep.fallback` numbers these cases; none stops the loop.
    """

    def __init__(self, of: Transcription, solver: Solver, weights: np.ndarray, goal: np.ndarray) -> None:
        self.of, self.solver, self.weights, self.goal = of, solver, np.asarray(weights, dtype=float), goal
        self.times = np.concatenate([[0.0], np.cumsum(of.problem.intervals)])
        self.plan: Plan | None = None
        self._shared = np.zeros(0), np.zeros(0)  # weights, and the parameters of a solution that follow from them

    def decide(self, state: np.ndarray) -> ControlStep:
        """The inputs at a measured state (2 n_q,)."""
        if self._shared[0] is not self.weights:  # which are replaced, never changed, where they are re-identified
            self._shared = self.weights, self.of.parameters(state, self.goal, self.weights)[self.of.n_x :]
        shared = self._shared[1]
        parameters = np.concatenate([state, shared])
        if self.plan is None:
            inputs = self._held(shared)
            guess = self._rolled_out(state, inputs, shared)
        else:
            inputs, guess = self._shifted(self.plan, state)
        tries = [self.solver(parameters, guess)]
        if not _is_good(tries[0]):
            tries.append(self.solver(parameters, self._rolled_out(state, inputs, shared)))
        best = tries[-1] if _is_good(tries[-1]) else min(tries, key=lambda solution: solution.violation)
        seconds, iterations = sum(each.seconds for each in tries), sum(each.iterations for each in tries)
        killed = sum(each.out_of_time for each in tries)
        if not (_is_good(best) or best.violation < PASSABLE):
            return self._without_solution(best.status, iterations, seconds, killed)
        states, inner = self.of.states(best.variables), self.of.inner(best.variables)
        self.plan = Plan(states, inner[:, : self.of.n_u])
        u = self._limited(inner[0, : self.of.n_u])
        return ControlStep(u, len(tries) - 1, best.status, iterations, seconds, killed, states)

    def _without_solution(self, status: str, iterations: int, seconds: float, killed: int) -> ControlStep:
        """The inputs of the last good plan at this time; 0 after its end."""
        if self.plan is not None:
            self.plan.age += 1
            at = self.plan.age * self.of.problem.time_step
            if at < self.times[-1] - ROUNDING:
                u = self._limited(self.plan.inputs[self._interval_at(at)])
                return ControlStep(u, 2, status, iterations, seconds, killed, self.plan.states)
        return ControlStep(np.zeros(self.of.n_u), 3, status, iterations, seconds, killed)

    def _held(self, shared: np.ndarray) -> np.ndarray:
        """The inputs that hold the model at rest at the goal, in every interval."""
        n_q = self.of.model.n_q
        return np.tile(self._limited(shared[n_q : n_q + self.of.n_u]), (self.of.n_intervals, 1))

    def _shifted(self, plan: Plan, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The inputs of a plan from the present time on, and a guess: its states moved there, from the measured one."""
        at = self.times + (plan.age + 1) * self.of.problem.time_step
        inputs = plan.inputs[self._interval_at(at[:-1])]
        states = np.stack([np.interp(at, self.times, column) for column in plan.states.T], axis=1)
        states[0] = state
        return inputs, self.of.guess(states, inputs)

    def _rolled_out(self, state: np.ndarray, inputs: np.ndarray, shared: np.ndarray) -> np.ndarray:
        """A roll-out of the model; near the goal the state is held instead, because an open-loop motion may fall."""
        angles = [i for i, c in enumerate(self.of.model.system.coordinates) if c.is_angle and not c.cyclic]
        states = np.repeat(state[None], self.of.n_intervals + 1, axis=0)
        if np.all(np.cos(state[angles] - self.goal[angles]) > np.cos(NEAR_GOAL)):
            return self.of.guess(states, self._held(shared))
        reached = np.append(state[None], np.asarray(self.of.roll_out(state, inputs.T, shared)).T, axis=0)
        usable = np.logical_and.accumulate([True, *(np.abs(reached[1:]) < DIVERGED).all(axis=1)])
        states[usable] = reached[usable]
        states[~usable] = reached[usable][-1]
        return self.of.guess(states, inputs)

    def _interval_at(self, times: np.ndarray | float) -> np.ndarray:
        index = np.searchsorted(self.times, np.asarray(times) + ROUNDING, side="right") - 1
        return np.asarray(np.minimum(index, self.of.n_intervals - 1))

    def _limited(self, u: np.ndarray) -> np.ndarray:
        limit = np.array(self.of.problem.force_limit)
        return np.asarray(np.clip(u, -limit, limit))


def _is_good(solution: Solution) -> bool:
    return bool(np.all(np.isfinite(solution.variables))) and (solution.converged or solution.violation < GOOD_ENOUGH)
