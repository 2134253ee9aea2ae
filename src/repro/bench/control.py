"""Our controller against do-mpc: the processor time of a control step."""

import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import TypeVar

import numpy as np

from repro.bench.control_case import CASES, EQUAL, FAST, ControlCase, SolverChoice
from repro.bench.do_mpc_peer import Collocation
from repro.bench.pairing import PairedComparison, Pairs
from repro.bench.scale import BenchScale
from repro.control.interval import DEGREE, ELEMENTS
from repro.control.solver_process import GuardedSolver

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
        pairs = [(FAST, "fatrop, Runge-Kutta steps, compiled", collocation, "") for collocation in case.collocations]
        for way, label, collocation, how in (*pairs, (EQUAL, f"IPOPT, {equal.label}", equal, SAME_DISCRETISATION)):
            intervals = len(case.problem.intervals)
            protocol = PROTOCOL.format(section=case.section, intervals=intervals, version=version, how=how)
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
