"""One optimal control problem in our controller and in do-mpc: the processor time of a control step."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from repro.bench.comparison import Comparison
from repro.bench.do_mpc_peer import Collocation, DoMpc
from repro.bench.pairing import Pairs
from repro.bench.scale import Scale
from repro.control.closed_loop import SUBSTEPS, run_loop
from repro.control.conditions import Conditions, hanging_start
from repro.control.interval import DEGREE, ELEMENTS, Discretisation
from repro.control.predictive_controller import PredictiveController
from repro.control.predictive_model import PredictiveModel
from repro.control.problem import Obstacle, Problem, Weights
from repro.control.solver import Limits, SolverName, make_solver
from repro.control.solver_process import GuardedSolver
from repro.control.transcription import Transcription
from repro.mechanics.system import load
from repro.models.truth import Truth

Way = tuple[Discretisation, SolverName]
FAST: Way = ("shooting", "fatrop")
EQUAL: Way = ("collocation", "ipopt")
X_DES = 0.8  # m
LIMITS = Limits(tolerance=1e-4, iterations=40, seconds=2.0)
SPEED_LIMIT = 45.0  # m/s and rad/s
PROTOCOL = (
    "processor time of one control step, at the states of a swing-up from hanging that ours drives; the true model, "
    "the weights of {section}, soft obstacle, {intervals} intervals of 0.04 s; tolerance 1e-4 and at most 40 "
    "iterations for both, both warm-started by their last solution, the first step left out; one thread; in turn, "
    "{{pairs}} steps; do-mpc {version} with IPOPT and MUMPS; {how}"
)
BEST = "each in the cheapest of its discretisations whose largest state error over the horizon has a median below 1e-2"
ALIKE = "both by the same Gauss-Radau collocation with the accelerations implicit, and IPOPT"


@dataclass(frozen=True)
class ControlCase:
    """Problem (9) of one system with the paper's weights, and do-mpc's cheapest collocation that is accurate enough."""

    system: str
    section: str
    problem: Problem
    cheapest: Collocation

    @property
    def size(self) -> str:
        """A few words for the tables."""
        return f"{self.system.upper()}, {len(self.problem.intervals)} intervals"

    @cached_property
    def model(self) -> PredictiveModel:
        """The true system as a model."""
        system = load(self.system)
        return PredictiveModel(Truth(system), system)

    @property
    def weights(self) -> np.ndarray:
        """The true coefficients."""
        assert isinstance(self.model.model, Truth)
        return self.model.model.coefficients

    def ours(self, way: Way) -> PredictiveController:
        """Our controller, without a plan yet."""
        discretisation, solver = way
        transcription = Transcription(self.model, self.problem, discretisation)
        return PredictiveController(transcription, make_solver(transcription, solver, LIMITS), self.weights, X_DES)

    def theirs(self, collocation: Collocation) -> DoMpc:
        """do-mpc's controller, not set up yet."""
        return DoMpc(self.model, self.problem, self.weights, X_DES, collocation, LIMITS.tolerance, LIMITS.iterations)

    def states(self, steps: int) -> np.ndarray:
        """The states of the true plant at so many control steps of a swing-up, (step, 2 n_q)."""
        controller, start = self.ours(FAST), hanging_start(self.model.system, X_DES)
        step = self.problem.time_step
        try:
            loop = run_loop(
                self.model.system, controller, start, Conditions(),
                time_step=step, seconds=steps * step, obstacle=self.problem.obstacle,
            )  # fmt: skip
        finally:
            controller.solver.close()
        return loop.states[:-1:SUBSTEPS]


CASES = (
    ControlCase(
        "sip",
        "V-A.1",
        Problem(
            intervals=(0.04,) * 20,
            running=Weights(potential=1.0, position=1.0),
            terminal=Weights(kinetic=1.0, potential=1.0),
            obstacle=Obstacle(radius=0.3),
            speed_limit=SPEED_LIMIT,
        ),
        Collocation(degree=2, elements=1),
    ),
    ControlCase(
        "dip",
        "V-B.2",
        Problem(
            intervals=(0.04,) * 30,
            running=Weights(potential=1.0, position=10.0),
            terminal=Weights(kinetic=10.0, potential=10.0),
            obstacle=Obstacle(radius=0.1),
            speed_limit=SPEED_LIMIT,
        ),
        Collocation(degree=4, elements=1),
    ),
)


def control(scale: Scale, version: str) -> Iterator[Comparison]:
    """Each in its own way, then both in one discretisation with one solver."""
    equal = Collocation(DEGREE, ELEMENTS, implicit=True)
    for case in CASES:
        for label, way, collocation, how in (
            ("fatrop, Runge-Kutta steps, compiled", FAST, case.cheapest, BEST),
            (f"IPOPT, {equal.label}", EQUAL, equal, ALIKE),
        ):
            protocol = PROTOCOL.format(
                section=case.section, intervals=len(case.problem.intervals), version=version, how=how
            )
            measure = partial(steps_in_turn, case, way, collocation, scale.control_steps)
            yield Comparison("control", label, f"do-mpc, {collocation.label}", case.size, 1, protocol, measure)


def steps_in_turn(case: ControlCase, way: Way, collocation: Collocation, steps: int) -> Pairs:
    """Time both controllers at every state of a swing-up but the first, where they make their first plan."""
    first, *others = case.states(1 + steps)
    ours, theirs = case.ours(way), case.theirs(collocation)
    try:
        theirs.start(first)
        theirs.force(first)
        ours.decide(first)
        pairs = [(_our_seconds(ours, state), _their_seconds(theirs, state)) for state in others]
    finally:
        ours.solver.close()
    return Pairs(*np.array(pairs).T)


def _our_seconds(controller: PredictiveController, state: np.ndarray) -> float:
    started = time.process_time()
    decision = controller.decide(state)
    here = time.process_time() - started
    return here + decision.seconds if isinstance(controller.solver, GuardedSolver) else here


def _their_seconds(peer: DoMpc, state: np.ndarray) -> float:
    started = time.process_time()
    peer.force(state)
    return time.process_time() - started
