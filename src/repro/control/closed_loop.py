"""A controller and the true plant in a closed loop, simulated in sub-steps."""

from dataclasses import dataclass

import numpy as np

from repro.control.conditions import Conditions, Start, measured, plant_of
from repro.control.controller import Controller, ControlStep
from repro.control.geometry import Disc
from repro.control.goal import Outcome, judge
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import under_inputs
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System

SUBSTEPS = 8  # per control step: 5 ms at 0.04 s


@dataclass(frozen=True)
class ClosedLoop:
    """One closed loop.

    time       (n,) of the sub-steps, s
    states     (n, 2 n_q) of the plant; nan from where the loop was stopped
    clearance  (n,) distance of the nearest link to the disc, m; None without a disc
    steps      one per control step
    """

    plant: System
    start: Start
    time: np.ndarray
    states: np.ndarray
    clearance: np.ndarray | None
    steps: list[ControlStep]
    outcome: Outcome

    @property
    def inputs(self) -> np.ndarray:
        """The inputs of the controller at each control step, (n_steps, n_u)."""
        return np.array([step.u for step in self.steps])


def run_loop(
    system: System,
    controller: Controller,
    start: Start,
    conditions: Conditions,
    *,
    time_step: float,
    seconds: float,
    disc: Disc | None,
    bounds: np.ndarray | None = None,
) -> ClosedLoop:
    """Drive the plant of the conditions, with their masses, lengths and friction, from a start.

    bounds: of the absolute values of a state, (2 n_q,); a loop beyond is stopped.
    """
    plant = plant_of(system, conditions, start)
    generator = np.random.default_rng([*start.seed, 2])
    n_steps, late = round(seconds / time_step), round(conditions.delay / time_step * SUBSTEPS)
    states = np.full((n_steps * SUBSTEPS + 1, 2 * system.n_q), np.nan)
    states[0] = start.state
    observed = measured(states[0], system, conditions.noise, generator)
    steps: list[ControlStep] = []
    u = np.zeros(len(system.inputs))
    bounds = np.full(len(start.state), np.inf) if bounds is None else bounds
    acceleration = under_inputs(dynamics_of(plant).acceleration, plant)
    # a plant of its own for every start: not worth a compilation each
    engine = "casadi" if conditions.mismatch and conditions.mismatch_kind == "physical" else "auto"
    for k in range(n_steps):
        step = controller.decide(observed)
        steps.append(step)
        commanded = np.repeat([u, step.u], [late, SUBSTEPS - late], axis=0)
        u = step.u
        first = k * SUBSTEPS
        held = (commanded + conditions.disturbance * generator.standard_normal(len(u)))[None]
        motion = simulate(
            acceleration, states[None, first], held, time_step / SUBSTEPS, angles=plant.angles, engine=engine
        )
        states[first : first + SUBSTEPS + 1] = motion[0]
        now = states[first + SUBSTEPS]
        if not np.all(np.isfinite(now)) or np.any(np.abs(now) > bounds):
            states[first + 1 :] = np.nan
            break
        samples = measured(motion[0], system, conditions.noise, generator)
        samples[0] = observed
        controller.observe(samples, commanded)
        observed = samples[-1]
    time = np.arange(len(states)) * time_step / SUBSTEPS
    clearance = None if disc is None else disc.clearance(plant, states[:, : system.n_q])
    outcome = judge(time, states, clearance, start.goal)
    return ClosedLoop(plant, start, time, states, clearance, steps, outcome)
