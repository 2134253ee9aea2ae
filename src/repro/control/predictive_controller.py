"""Model predictive control: problem (9) solved again at every step, from the shifted plan of the step before."""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from repro.control.decision import Decision
from repro.control.nonlinear import Solution, Solver
from repro.control.transcription import Transcription

GOOD_ENOUGH = 1e-3  # of a constraint's violation, where the solver did not converge
NEAR_UPRIGHT = np.deg2rad(30)
WILD = 1e3  # a state beyond is no guess
ROUNDING = 1e-9  # s, of sums of time steps


@dataclass
class Plan:
    """The last good solution and how many steps ago it was made."""

    states: np.ndarray
    forces: np.ndarray
    age: int = 0


class PredictiveController:
    """Solves from the shifted plan; if that fails from a roll-out of the shifted forces; then keeps to the last plan.

    A solution counts when it converged, or when its constraints hold to 1e-3. Every resort is counted in its order, and
    none of them stops the loop.
    """

    def __init__(self, of: Transcription, solver: Solver, weights: np.ndarray, x_des: float) -> None:
        self.of, self.solver, self.weights, self.x_des = of, solver, np.asarray(weights, dtype=float), x_des
        self.times = np.concatenate([[0.0], np.cumsum(of.problem.intervals)])
        self.plan: Plan | None = None
        stage = of.prediction
        self._advance = ca.Function(
            "advance", [stage.state, stage.inner, stage.parameters, stage.data], [stage.following], {"cse": True}
        )

    def decide(self, state: np.ndarray) -> Decision:
        """Solve, with resorts."""
        forces = np.zeros(self.of.n_intervals) if self.plan is None else self._shifted_forces()
        guesses = [self._rolled_out(state, forces)] if self.plan is None else [self._shifted(state, forces)]
        seconds, iterations, killed, status = 0.0, 0, 0, ""
        for attempt in range(2):
            if attempt:
                guesses.append(self._rolled_out(state, forces))
            parameters = self.of.parameters(state, self.x_des, self.weights)
            solution = self.solver(parameters, guesses[attempt])
            seconds, iterations = seconds + solution.seconds, iterations + solution.iterations
            killed, status = killed + solution.out_of_time, solution.status
            if _is_good(solution):
                states, inner = self.of.states(solution.variables), self.of.inner(solution.variables)
                self.plan = Plan(states, inner[:, 0])
                return Decision(self._limited(inner[0, 0]), attempt, status, iterations, seconds, killed, states)
        return self._without_solution(status, iterations, seconds, killed)

    def observe(self, samples: np.ndarray, forces: np.ndarray) -> None:
        """Nothing is learned from what happens."""

    def _without_solution(self, status: str, iterations: int, seconds: float, killed: int) -> Decision:
        """The next force of the last good plan, in its own time; no force after its end."""
        if self.plan is not None:
            self.plan.age += 1
            at = self.plan.age * self.of.problem.time_step
            if at < self.times[-1] - ROUNDING:
                force = self._limited(self.plan.forces[self._interval_at(at)])
                return Decision(force, 2, status, iterations, seconds, killed, self.plan.states)
        return Decision(0.0, 3, status, iterations, seconds, killed)

    def _shifted_forces(self) -> np.ndarray:
        assert self.plan is not None
        passed = (self.plan.age + 1) * self.of.problem.time_step
        return self.plan.forces[self._interval_at(self.times[:-1] + passed)]

    def _shifted(self, state: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """The plan as it lies a step later, begun where we are."""
        assert self.plan is not None
        at = self.times + (self.plan.age + 1) * self.of.problem.time_step
        states = np.stack([np.interp(at, self.times, column) for column in self.plan.states.T], axis=1)
        states[0] = state
        return self.of.guess(states, forces)

    def _rolled_out(self, state: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """The model's motion under the forces; near upright, where that would fall, everything as it is."""
        system = self.of.model.system
        angles = list(system.angles)
        states = np.repeat(state[None], self.of.n_intervals + 1, axis=0)
        if np.all(np.cos(state[angles] - system.upright[angles]) > np.cos(NEAR_UPRIGHT)):
            return self.of.guess(states, np.zeros_like(forces))
        shared = np.append(self.x_des, self.weights)
        for k, (length, force) in enumerate(zip(self.of.problem.intervals, forces, strict=True)):
            following = np.asarray(self._advance(states[k], force, shared, [length, 0.0])).ravel()
            if not np.all(np.abs(following) < WILD):
                break
            states[k + 1 :] = following
        return self.of.guess(states, forces)

    def _interval_at(self, times: np.ndarray | float) -> np.ndarray:
        found = np.searchsorted(self.times, np.asarray(times) + ROUNDING, side="right") - 1
        return np.minimum(found, self.of.n_intervals - 1)

    def _limited(self, force: float) -> float:
        limit = self.of.problem.force_limit
        return float(np.clip(force, -limit, limit))


def _is_good(solution: Solution) -> bool:
    return bool(np.all(np.isfinite(solution.variables))) and (solution.converged or solution.violation < GOOD_ENOUGH)
