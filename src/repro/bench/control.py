"""Our controller against do-mpc, on the paper's problem of each of its systems: the time of a control step."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TypeVar

import casadi as ca
import numpy as np

from repro.bench.do_mpc_peer import Collocation, DoMpc
from repro.bench.pairing import PairedComparison, Pairs
from repro.bench.scale import BenchScale
from repro.control.closed_loop import SUBSTEPS, run_loop
from repro.control.conditions import Conditions, Start
from repro.control.interval import DEGREE, ELEMENTS
from repro.control.optimal_control_problem import (
    Discretisation,
    NodeWeights,
    Obstacle,
    OptimalControlProblem,
    SolverName,
)
from repro.control.predictive_controller import PredictiveController
from repro.control.predictive_model import PredictiveModel
from repro.control.solver import Limits, make_solver
from repro.control.solver_process import GuardedSolver
from repro.control.task import Task
from repro.control.transcription import Transcription
from repro.mechanics.system import load
from repro.models.kinds.truth import Truth

SolverChoice = tuple[Discretisation, SolverName]
FAST: SolverChoice = ("shooting", "fatrop")
EQUAL: SolverChoice = ("collocation", "ipopt")
X_DES = 0.8  # m
LIMITS = Limits(tolerance=1e-4, iterations=40, seconds=2.0)
SPEED_LIMIT = 45.0  # m/s and rad/s


@dataclass(frozen=True)
class ControlCase:
    """Problem (9) of one system with the paper's weights, and what makes a plan accurate to 1e-2."""

    system: str
    section: str  # of the paper
    intervals: int
    weight: float  # of position, and of both terminal energies
    radius: float  # of the obstacle, m
    substeps: int  # of this project's Runge-Kutta steps
    collocation: Collocation  # the cheapest of do-mpc that is about as accurate

    @property
    def size(self) -> str:
        """A label for the tables."""
        return f"{self.system.upper()}, {self.intervals} intervals"

    @cached_property
    def problem(self) -> OptimalControlProblem:
        """Problem (9)."""
        return OptimalControlProblem(
            intervals=(0.04,) * self.intervals,
            stage_cost=NodeWeights(potential=1.0, position=self.weight),
            terminal_cost=NodeWeights(kinetic=self.weight, potential=self.weight),
            obstacle=Obstacle(radius=self.radius),
            speed_limit=SPEED_LIMIT,
        )

    @cached_property
    def model(self) -> PredictiveModel:
        """The true system as a model."""
        system = load(self.system)
        return PredictiveModel(Truth(system), system)

    @property
    def start(self) -> Start:
        """Hanging at rest, and upright at X_DES as the goal."""
        ((start, _),) = Task(name="hanging", x_des=(X_DES,)).starts(self.model.system, 1)
        return start

    @property
    def weights(self) -> np.ndarray:
        """The true coefficients."""
        assert isinstance(self.model.model, Truth)
        return self.model.model.coefficients

    def ours(self, way: SolverChoice) -> PredictiveController:
        """Our controller, without a plan yet."""
        discretisation, solver = way
        transcription = Transcription(self.model, self.problem, discretisation, self.substeps)
        return PredictiveController(
            transcription, make_solver(transcription, solver, LIMITS), self.weights, self.start.goal.q
        )

    def theirs(self, collocation: Collocation) -> DoMpc:
        """do-mpc's controller, not set up yet."""
        return DoMpc(self.model, self.problem, self.weights, X_DES, collocation, LIMITS.tolerance, LIMITS.iterations)

    @cached_property
    def exact(self) -> ca.Function:
        """The motion over one interval under a constant force, to 1e-10: x0, p -> xf."""
        x, f = ca.SX.sym("x", 2 * self.model.n_q), ca.SX.sym("f")
        motion = {"x": x, "p": f, "ode": self.model.derivative(x, f, self.weights)}
        tolerances = {"abstol": 1e-10, "reltol": 1e-10}
        return ca.integrator("exact", "cvodes", motion, 0, self.problem.time_step, tolerances)

    def state_error(self, states: np.ndarray, forces: np.ndarray) -> float:
        """The largest difference, in m, rad, m/s or rad/s, of a plan to the exact motion; forces: (nodes - 1, 1)."""
        state, largest = states[0], 0.0
        for force, planned in zip(forces, states[1:], strict=True):
            state = np.asarray(self.exact(x0=state, p=force)["xf"]).ravel()
            largest = max(largest, float(np.abs(state - planned).max()))
        return largest

    def states(self, steps: int) -> np.ndarray:
        """The states of the true plant at so many control steps of a swing-up, (step, 2 n_q)."""
        controller, step = self.ours(FAST), self.problem.time_step
        try:
            loop = run_loop(
                self.model.system, controller, self.start, Conditions(),
                time_step=step, seconds=steps * step, disc=self.problem.obstacle,
            )  # fmt: skip
        finally:
            controller.solver.close()
        return loop.states[:-1:SUBSTEPS]


CASES = (
    ControlCase("sip", "V-A.1", 20, weight=1.0, radius=0.3, substeps=2, collocation=Collocation(2, 1)),
    ControlCase("dip", "V-B.2", 30, weight=10.0, radius=0.1, substeps=4, collocation=Collocation(4, 1)),
)
PROTOCOL = (
    "processor time of one control step, at the states of a swing-up from hanging that ours drives; the true model, "
    "the weights of {section}, soft obstacle, {intervals} intervals of 0.04 s; tolerance 1e-4 and at most 40 "
    "iterations for both, both warm-started by their last solution, the first step left out; one thread; in turn, "
    "{{pairs}} steps; do-mpc {version} with IPOPT and MUMPS{how}; largest state error over the horizon, median of the "
    "steps: {{found}}"
)
CHECKED = 4  # every CHECKED steps the plans are compared with the exact motion, which takes longer than a step
Result = TypeVar("Result")
SAME_DISCRETISATION = ", as ours; both by the same collocation with the accelerations implicit"


def control(scale: BenchScale, version: str) -> Iterator[PairedComparison]:
    """Each in its own way, then both in one discretisation with one solver."""
    equal = Collocation(DEGREE, ELEMENTS, implicit=True)
    for case in CASES:
        for way, label, collocation, how in (
            (FAST, "fatrop, Runge-Kutta steps, compiled", case.collocation, ""),
            (EQUAL, f"IPOPT, {equal.label}", equal, SAME_DISCRETISATION),
        ):
            protocol = PROTOCOL.format(section=case.section, intervals=case.intervals, version=version, how=how)
            measure = partial(steps_in_turn, case, way, collocation, scale.control_steps)
            yield PairedComparison("control", label, f"do-mpc, {collocation.label}", case.size, 1, protocol, measure)


def steps_in_turn(case: ControlCase, way: SolverChoice, collocation: Collocation, steps: int) -> Pairs:
    """Time both controllers at every state of a swing-up but the first, where they make their first plan."""
    first, *others = case.states(1 + steps)
    ours, theirs = case.ours(way), case.theirs(collocation)
    seconds, errors = [], []
    try:
        theirs.start(first)
        theirs.force(first)
        ours.decide(first)
        for number, state in enumerate(others):
            decision, spent = _timed(ours.decide, state)
            # a guarded solver runs in a process of its own, whose time is not part of this one's
            spent += decision.seconds if isinstance(ours.solver, GuardedSolver) else 0.0
            seconds.append((spent, _timed(theirs.force, state)[1]))
            if number % CHECKED:
                continue
            assert ours.plan is not None
            errors.append([case.state_error(*plan) for plan in ((ours.plan.states, ours.plan.inputs), theirs.plan)])
    finally:
        ours.solver.close()
    mine, other = np.median(errors, axis=0)
    mine_s, other_s = np.array(seconds).T
    return Pairs(mine_s, other_s, found=f"ours {mine:.1e}, do-mpc {other:.1e}")


def _timed(call: Callable[[np.ndarray], Result], state: np.ndarray) -> tuple[Result, float]:
    started = time.process_time()
    return call(state), time.process_time() - started
