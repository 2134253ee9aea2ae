"""A solver in its own process: the same answers, and it is killed when it takes too long."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from optional import needs_compiler

from repro.codegen.c_library import library_file
from repro.control.shooting import shooting_code
from repro.control.solver import Limits, compiled_programme
from repro.control.solver_process import GuardedSolver

pytestmark = needs_compiler


@pytest.fixture
def of(transcribe, problem):
    return transcribe(problem)


@pytest.fixture
def request_of(of, state):
    guess = of.guess(np.repeat(state[None], of.n_intervals + 1, axis=0), np.zeros((of.n_intervals, 1)))
    return of.parameters(state, np.array([0.8, 0.0]), of.model.model.coefficients), guess


def test_the_answer_is_the_same(of, request_of):
    programme = compiled_programme(of, Limits())
    here = programme.start()(*request_of)
    with closing(GuardedSolver(programme, 5.0)) as guarded:
        there = guarded(*request_of)
        process = guarded.process
    np.testing.assert_array_equal(there.variables, here.variables)
    assert there.seconds > 0
    assert process.poll() is not None, "it ends with its guard"


def test_a_stalled_solver_is_killed_and_started_again(of, request_of):
    code = shooting_code(of).replace(
        "static void cost(double *f) {", "static void cost(double *f) { for (;;) *f += 1.0;"
    )
    endless = replace(compiled_programme(of, Limits()), library=str(library_file(code, ("-O0",))))
    with closing(GuardedSolver(endless, 0.2)) as guarded:
        first = guarded(*request_of)
        assert (first.status, first.converged, first.violation) == ("killed", False, np.inf)
        assert np.all(np.isnan(first.variables))
        guarded.programme = compiled_programme(of, Limits())
        assert guarded(*request_of).converged
