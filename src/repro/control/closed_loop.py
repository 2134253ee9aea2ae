"""A controller and the true plant in a closed loop, simulated in sub-steps."""

from dataclasses import dataclass

import numpy as np

from repro.control.conditions import Conditions, Start, measured, plant_of
from repro.control.controller import Controller, ControlStep
from repro.control.geometry import Disc
from repro.control.outcome import Outcome, judge
from repro.mechanics.derive import dynamics_of
from repro.mechanics.inputs import under_inputs
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System

SUBSTEPS = 8  # per control step: 5 ms at 0.04 s
FARTHEST, FASTEST = 10.0, 40.0  # position in m, velocity in m/s or rad/s: a loop beyond is stopped


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
    def forces(self) -> np.ndarray:
        """The force of the controller at each control step, (n_steps,) in N."""
        return np.array([step.force for step in self.steps])


def run_loop(
    system: System,
    controller: Controller,
    start: Start,
    conditions: Conditions,
    *,
    time_step: float,
    seconds: float,
    disc: Disc | None,
) -> ClosedLoop:
    """Drive the plant of the conditions from a start.

    The system must be a cart with links and one input. Its masses, lengths and friction are those of the conditions.
    """
    plant = plant_of(system, conditions, start)
    generator = np.random.default_rng([*start.seed, 2])
    n_steps, late = round(seconds / time_step), round(conditions.delay / time_step * SUBSTEPS)
    states = np.full((n_steps * SUBSTEPS + 1, 2 * system.n_q), np.nan)
    states[0] = start.state
    observed = measured(states[0], system, conditions.noise, generator)
    steps, force = [], 0.0
    acceleration = under_inputs(dynamics_of(plant).acceleration, plant)
    # a plant of its own for every start: not worth a compilation each
    engine = "casadi" if conditions.mismatch and conditions.mismatch_kind == "physical" else "auto"
    for k in range(n_steps):
        step = controller.decide(observed)
        steps.append(step)
        commanded = np.repeat([force, step.force], [late, SUBSTEPS - late])
        force = step.force
        first = k * SUBSTEPS
        disturbance = conditions.disturbance * generator.standard_normal()
        held = (commanded + disturbance)[None, :, None]
        motion = simulate(
            acceleration, states[None, first], held, time_step / SUBSTEPS, angles=plant.angles, engine=engine
        )
        states[first : first + SUBSTEPS + 1] = motion[0]
        now = states[first + SUBSTEPS]
        if not np.all(np.isfinite(now)) or abs(now[0]) > FARTHEST or np.max(np.abs(now[system.n_q :])) > FASTEST:
            states[first + 1 :] = np.nan
            break
        samples = measured(motion[0], system, conditions.noise, generator)
        samples[0] = observed
        controller.observe(samples, commanded)
        observed = samples[-1]
    time = np.arange(len(states)) * time_step / SUBSTEPS
    clearance = None if disc is None else disc.clearance(plant, states[:, : system.n_q])
    outcome = judge(time, states, clearance, system, start.x_des)
    return ClosedLoop(plant, start, time, states, clearance, steps, outcome)
