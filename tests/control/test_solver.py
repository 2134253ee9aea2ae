"""Solvers and discretisations find the same trajectory, and it solves the problem."""

from dataclasses import replace

import numpy as np
import pytest
from optional import needs_compiler

from repro.control import solver as module
from repro.control.optimal_control_problem import Obstacle
from repro.control.programme import programme
from repro.control.solver import Limits, compiled_programme, ipopt, make_solver
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate

TIGHT = Limits(tolerance=1e-8, iterations=200)


def solved(of, state, make):
    guess = of.guess(np.repeat(state[None], of.n_intervals + 1, axis=0), np.zeros((of.n_intervals, 1)))
    parameters = of.parameters(state, np.array([0.8, 0.0]), of.model.model.coefficients)
    solution = make(of)(parameters, guess)
    assert solution.converged and solution.violation < 1e-8
    return solution, parameters


@needs_compiler
@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
@pytest.mark.parametrize("hard", [False, True], ids=["soft", "hard"])
def test_fatrop_and_ipopt_agree(problem, transcribe, state, discretisation, hard):
    of = transcribe(replace(problem, obstacle=Obstacle(constraint=hard)), discretisation)
    reference, _ = solved(of, state, lambda of: ipopt(of, TIGHT))
    fast, _ = solved(of, state, lambda of: compiled_programme(of, TIGHT).start())
    np.testing.assert_allclose(fast.variables, reference.variables, atol=1e-6)
    assert fast.objective == pytest.approx(reference.objective, abs=1e-8)


def test_the_discretisations_agree(problem, transcribe, state):
    explicit, implicit = (transcribe(problem, name) for name in ("shooting", "collocation"))
    shot, _ = solved(explicit, state, lambda of: ipopt(of, TIGHT))
    collocated, _ = solved(implicit, state, lambda of: ipopt(of, TIGHT))
    np.testing.assert_allclose(explicit.states(shot.variables), implicit.states(collocated.variables), atol=1e-3)
    np.testing.assert_allclose(
        explicit.inner(shot.variables)[:, 0], implicit.inner(collocated.variables)[:, 0], atol=2e-3
    )


@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
def test_the_plan_is_a_motion_of_the_plant(problem, transcribe, system, state, discretisation):
    of = transcribe(problem, discretisation)
    solution, _ = solved(of, state, lambda of: ipopt(of, TIGHT))
    forces = of.inner(solution.variables)[:, :1]
    tau = np.append(forces, np.zeros_like(forces), axis=1)[None]
    motion = simulate(dynamics_of(system).acceleration, state[None], tau, 0.04)[0]
    np.testing.assert_allclose(of.states(solution.variables), motion, atol=5e-4)


def test_the_kkt_conditions_hold(problem, transcribe, state):
    """Multipliers recovered by least squares make the Lagrangian stationary where no bound is active."""
    of = transcribe(problem)
    solution, parameters = solved(of, state, lambda of: ipopt(of, TIGHT))
    derivatives = programme(of).function("derivatives", ["grad_f_x", "jac_g_x"])
    gradient, jacobian = (np.asarray(value) for value in derivatives(solution.variables, parameters))
    limits = of.bounds()["ubx"]
    free = np.abs(solution.variables) < limits - 1e-4
    multipliers, *_ = np.linalg.lstsq(jacobian.T[free], -gradient[free, 0], rcond=None)
    assert np.abs(gradient[free, 0] + jacobian.T[free] @ multipliers).max() < 1e-5
    assert 0 < np.sum(~free) < of.n_intervals


def test_without_a_compiler_ipopt_stands_in(problem, transcribe, state, monkeypatch):
    monkeypatch.setattr(module, "has_compiler", lambda: False)
    of = transcribe(problem)
    solution, _ = solved(of, state, lambda of: make_solver(of, "fatrop", TIGHT))
    assert solution.status == "Solve_Succeeded" and solution.seconds > 0
