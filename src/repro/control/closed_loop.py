"""A controller on the true plant, simulated in sub-steps."""

from dataclasses import dataclass

import numpy as np

from repro.control.conditions import Conditions, Start, measured, plant_of
from repro.control.decision import Controller, Decision
from repro.control.geometry import clearance
from repro.control.optimal_control_problem import Obstacle
from repro.control.outcome import Outcome, judge
from repro.mechanics.derive import dynamics_of
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System

SUBSTEPS = 8  # a control step: 5 ms at 0.04 s
FARTHEST, FASTEST = 10.0, 40.0  # a loop beyond is given up


@dataclass(frozen=True)
class ClosedLoop:
    """One closed loop.

    time       (n,) of the sub-steps, s
    states     (n, 2 n_q) of the plant; nan from where the loop was given up
    clearance  (n,) distance of the nearest link to the disc, m; None without a disc
    decisions  one a control step
    """

    plant: System
    start: Start
    time: np.ndarray
    states: np.ndarray
    clearance: np.ndarray | None
    decisions: list[Decision]
    outcome: Outcome

    @property
    def forces(self) -> np.ndarray:
        """The force decided at each control step, N."""
        return np.array([decision.force for decision in self.decisions])


def run_loop(
    system: System,
    controller: Controller,
    start: Start,
    conditions: Conditions,
    *,
    time_step: float,
    seconds: float,
    obstacle: Obstacle | None,
) -> ClosedLoop:
    """Drive the plant of the conditions from a start for so long."""
    plant = plant_of(system, conditions, start)
    generator = np.random.default_rng([*start.seed, 2])
    steps, late = round(seconds / time_step), round(conditions.delay / time_step * SUBSTEPS)
    states = np.full((steps * SUBSTEPS + 1, 2 * system.n_q), np.nan)
    states[0] = start.state
    seen = measured(states[0], system, conditions.noise, generator)
    decisions, force = [], 0.0
    acceleration = dynamics_of(plant).acceleration
    # a plant of its own for every start: not worth a compilation each
    engine = "casadi" if conditions.mismatch and conditions.mismatch_kind == "physical" else "auto"
    for k in range(steps):
        decision = controller.decide(seen)
        decisions.append(decision)
        commanded = np.repeat([force, decision.force], [late, SUBSTEPS - late])
        force = decision.force
        first = k * SUBSTEPS
        besides = conditions.disturbance * generator.standard_normal()
        tau = (commanded + besides)[None, :, None] * plant.input_map[:, 0]
        travelled = simulate(
            acceleration, states[None, first], tau, time_step / SUBSTEPS, angles=plant.angles, engine=engine
        )
        states[first : first + SUBSTEPS + 1] = travelled[0]
        now = states[first + SUBSTEPS]
        if not np.all(np.isfinite(now)) or abs(now[0]) > FARTHEST or np.max(np.abs(now[system.n_q :])) > FASTEST:
            states[first + 1 :] = np.nan
            break
        samples = measured(travelled[0], system, conditions.noise, generator)
        samples[0] = seen
        controller.observe(samples, commanded)
        seen = samples[-1]
    time = np.arange(len(states)) * time_step / SUBSTEPS
    near = None
    if obstacle is not None:
        near = clearance(plant, states[:, : system.n_q], obstacle.centre, obstacle.radius)
    outcome = judge(time, states, near, system, start.x_des)
    return ClosedLoop(plant, start, time, states, near, decisions, outcome)
