"""Model predictive control: problem (9) solved again at every step, from the shifted plan of the step before."""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from repro.control.decision import Decision
from repro.control.nonlinear import Solution, Solver
from repro.control.transcription import Transcription

GOOD_ENOUGH = 1e-3  # of a constraint's violation, where the solver did not converge
PASSABLE = 0.1  # where no try did better: nearer to the truth than a plan that is growing old
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

    A solution counts when it converged, or when its constraints hold to 1e-3; after the second try the better of both
    counts when they hold to 0.1, and the next step goes on from there. Every resort is counted in its order, and none
    of them stops the loop.
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
        guess = self._rolled_out(state, forces) if self.plan is None else self._shifted(state, forces)
        parameters = self.of.parameters(state, self.x_des, self.weights)
        tries = [self.solver(parameters, guess)]
        if not _is_good(tries[0]):
            tries.append(self.solver(parameters, self._rolled_out(state, forces)))
        best = tries[-1] if _is_good(tries[-1]) else min(tries, key=lambda solution: solution.violation)
        seconds, iterations = sum(each.seconds for each in tries), sum(each.iterations for each in tries)
        killed = sum(each.out_of_time for each in tries)
        if not (_is_good(best) or best.violation < PASSABLE):
            return self._without_solution(best.status, iterations, seconds, killed)
        states, inner = self.of.states(best.variables), self.of.inner(best.variables)
        self.plan = Plan(states, inner[:, 0])
        force = self._limited(inner[0, 0])
        return Decision(force, len(tries) - 1, best.status, iterations, seconds, killed, states)

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
