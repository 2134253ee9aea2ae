"""The controller's resorts in their order, and its guesses."""

import numpy as np
import pytest

from repro.control.nonlinear_solver import Solution
from repro.control.predictive_controller import PredictiveController
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import under_inputs
from repro.mechanics.simulate import simulate

STEP = 0.04


class Scripted:
    """Answers as told: a force sequence that converges, or None for a failure."""

    def __init__(self, of, answers):
        self.of, self.answers, self.guesses = of, list(answers), []

    def __call__(self, parameters, guess):
        self.guesses.append(guess)
        forces = self.answers.pop(0)
        if forces is None:
            return Solution(guess, False, 1.0, 3, "failed", 0.0, 0.1)
        states = np.linspace(parameters[: self.of.n_x], np.zeros(self.of.n_x), self.of.n_intervals + 1)
        return Solution(self.of.guess(states, np.asarray(forces, dtype=float)[:, None]), True, 0.0, 2, "ok", 0.0, 0.1)


@pytest.fixture
def controlled(transcribe, problem):
    def make(answers):
        of = transcribe(problem)
        return PredictiveController(of, Scripted(of, answers), of.model.model.coefficients, np.array([0.8, 0.0]))

    return make


RAMP = np.linspace(-1.0, 0.9, 20)


def test_resorts_come_in_their_order_and_are_counted(controlled, state):
    controller = controlled([RAMP, None, RAMP, *[None] * 100])
    decisions = [controller.decide(state) for _ in range(24)]
    assert [decision.fallback for decision in decisions] == [0, 1, *[2] * 19, 3, 3, 3]
    np.testing.assert_allclose([decision.u[0] for decision in decisions[1:21]], RAMP)
    assert decisions[-1].u == 0.0
    assert (decisions[0].seconds, decisions[1].seconds) == (0.1, 0.2)
    assert decisions[1].iterations == 5 and decisions[2].iterations == 6


def test_a_solution_that_is_given_up_is_counted_even_when_the_next_one_is_good(controlled, state):
    controller = controlled([RAMP])
    answer = controller.solver

    def stalls_once(parameters, guess):
        controller.solver = answer
        return Solution(np.full_like(guess, np.nan), False, np.inf, 0, "killed", np.nan, 0.25)

    controller.solver = stalls_once
    decision = controller.decide(state)
    assert (decision.fallback, decision.status, decision.killed) == (1, "ok", 1)


def test_without_any_plan_there_is_no_force(controlled, state):
    decision = controlled([None, None]).decide(state)
    assert (decision.u[0], decision.fallback, decision.status) == (0.0, 3, "failed")


def test_an_iterate_that_keeps_the_constraints_counts(controlled, state):
    controller = controlled([])
    guess = controller.of.guess(np.repeat(state[None], 21, axis=0), RAMP[:, None])

    def nearly(parameters, given):
        return Solution(guess, False, 9e-4, 40, "maximum iterations", 0.0)

    controller.solver = nearly
    decision = controller.decide(state)
    assert (decision.fallback, decision.u[0]) == (0, -1.0)


@pytest.mark.parametrize(("violations", "fallback"), [((0.02, 0.05), 1), ((0.05, 0.02), 1), ((0.5, 0.2), 3)])
def test_the_better_of_two_failures_may_do(controlled, state, violations, fallback):
    """Nothing converges: what nearly keeps the constraints is followed, and the next step goes on from it."""
    controller = controlled([])
    forces = {violation: np.full((20, 1), violation) for violation in violations}
    left = list(violations)

    def nearly(parameters, given):
        variables = controller.of.guess(np.repeat(state[None], 21, axis=0), forces[left[0]])
        return Solution(variables, False, left.pop(0), 40, "maximum iterations", 0.0)

    controller.solver = nearly
    decision = controller.decide(state)
    assert (decision.fallback, decision.u[0]) == (fallback, 0.02 if fallback == 1 else 0.0)
    assert (controller.plan is not None) == (fallback == 1)


def test_the_guess_is_the_shifted_plan_begun_where_we_are(controlled, state):
    controller = controlled([RAMP, RAMP])
    controller.decide(state)
    plan = controller.plan.states
    controller.decide(state + 0.01)
    guess = controller.solver.guesses[1]
    states, forces = controller.of.states(guess), controller.of.inner(guess)[:, 0]
    np.testing.assert_array_equal(states[0], state + 0.01)
    np.testing.assert_allclose(states[1:-1], plan[2:], atol=1e-12)
    np.testing.assert_allclose(forces, [*RAMP[1:], RAMP[-1]])


def test_on_a_grid_that_widens_the_plan_is_interpolated(transcribe, problem, state):
    from dataclasses import replace

    of = transcribe(replace(problem, intervals=(0.04, 0.04, 0.08, 0.08)))
    controller = PredictiveController(
        of, Scripted(of, [[1, 2, 3, 4], [0, 0, 0, 0]]), of.model.model.coefficients, np.array([0.8, 0.0])
    )
    controller.decide(state)
    plan = controller.plan.states
    controller.decide(state)
    states, forces = of.states(controller.solver.guesses[1]), of.inner(controller.solver.guesses[1])[:, 0]
    np.testing.assert_allclose(states[1], plan[2])
    np.testing.assert_allclose(states[2], (plan[2] + plan[3]) / 2)
    np.testing.assert_allclose(forces, [2, 3, 3, 4])


def test_the_first_guess_is_a_motion_of_the_model_or_rest_near_upright(controlled, state):
    controller = controlled([RAMP, RAMP])
    controller.decide(state)
    states = controller.of.states(controller.solver.guesses[0])
    assert np.ptp(states[:, 1]) > 0.2, "it swings"
    controller.plan = None
    upright = np.array([0.1, 0.2, 0.0, 0.5])
    controller.decide(upright)
    np.testing.assert_array_equal(controller.of.states(controller.solver.guesses[1]), np.tile(upright, (21, 1)))


def test_the_force_keeps_its_limit(controlled, state):
    assert controlled([np.full(20, 4.0000001)]).decide(state).u == [4.0]


@pytest.mark.parametrize("discretisation", ["shooting", "collocation"])
def test_a_roll_out_is_one_interval_after_another(transcribe, problem, state, discretisation):
    """The motion of the model under held inputs, whatever the discretisation of the problem."""
    of = transcribe(problem, discretisation)
    inputs = np.random.default_rng(0).normal(size=(1, of.n_intervals))
    shared = of.parameters(state, np.zeros(2), of.model.model.coefficients)[of.n_x :]
    reached = np.asarray(of.roll_out(state, inputs, shared))
    assert reached.shape == (of.n_x, of.n_intervals)
    system = of.model.system
    acceleration = under_inputs(dynamics_of(system).acceleration, system)
    motion = simulate(acceleration, state[None], inputs.T[None], problem.time_step)
    np.testing.assert_allclose(reached.T, motion[0, 1:], rtol=0, atol=1e-4)


def test_a_guess_stops_where_the_model_diverges(controlled, state):
    """The last usable state is held from there on."""
    controller = controlled([])
    shared = controller.of.parameters(state, controller.goal, controller.weights)[controller.of.n_x :]
    forces = np.where(np.arange(20) < 5, 1.0, 1e9)[:, None]
    states = controller.of.states(controller._rolled_out(state, forces, shared))
    assert np.abs(states).max() < 1e3 and np.unique(states[:6], axis=0).shape == (6, 4)
    np.testing.assert_array_equal(states[6:], np.tile(states[5], (15, 1)))
