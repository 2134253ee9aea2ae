"""The motion of a learned model: by a compiled simulator, or by predictions alone where it cannot be compiled."""

from collections.abc import Sequence

import numpy as np

from repro.codegen.lazy_torch import torch
from repro.mechanics.inputs import generalised_force, under_inputs
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System
from repro.models.model import Model, acceleration

FEW_STEPS = 1000  # of all trajectories: below this CasADi integrates in less time than a compiler takes
LARGEST = 2000  # weights: above this the generated simulator takes longer to compile than it saves
SUBSTEPS = 4  # of a sample time, where every one costs four predictions


def model_motion(
    model: Model,
    weights: np.ndarray,
    initial: np.ndarray,
    held: np.ndarray,
    time_step: float,
    angles: Sequence[int],
    system: System | None = None,
) -> np.ndarray:
    """States (batch, steps + 1, 2 n_q) of a model from `initial` (batch, 2 n_q), with weights (batch, n_parameters).

    held: over each step of time_step s, tau (batch, steps, n_q), or the inputs (batch, steps, n_u) of `system`.
    Integrated by RK4; not finite from where the motion diverges.
    """
    if is_compiled(model):
        motion = acceleration(model) if system is None else under_inputs(acceleration(model), system)
        engine = "casadi" if held.shape[0] * held.shape[1] < FEW_STEPS else "auto"
        return simulate(motion, initial, held, time_step, parameters=weights, angles=angles, engine=engine)
    members = len(np.unique(weights, axis=0))
    if not np.array_equal(weights, np.repeat(weights[:: len(weights) // members], len(weights) // members, axis=0)):
        members = len(weights)
    parameters = torch.from_numpy(np.ascontiguousarray(weights[:: len(weights) // members]))

    def of_members(array: np.ndarray) -> np.ndarray:
        return array.reshape(members, -1, array.shape[-1])

    states = np.empty((held.shape[1] + 1, members, len(held) // members, initial.shape[1]))
    states[0] = model.state(of_members(initial))
    for step in range(held.shape[1]):

        def rate(state: np.ndarray, step: int = step) -> np.ndarray:
            inputs = of_members(held[:, step])
            tau = inputs if system is None else generalised_force(system, state[..., : model.n_q], inputs)
            return model.state_rate(parameters, state, tau)

        state = states[step]
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(SUBSTEPS):
                state = rk4_step(rate, state, time_step / SUBSTEPS)
        states[step + 1] = np.where(np.isfinite(state).all(axis=-1, keepdims=True), state, np.nan)
    moved = np.stack([model.motion_of(parameters, state) for state in states], axis=2)
    moved[:, :, 0] = of_members(initial)
    return moved.reshape(len(held), *moved.shape[2:])


def is_compiled(model: Model) -> bool:
    """Whether the motion of a model is computed by compiled code."""
    return model.not_symbolic is None and model.n_parameters <= LARGEST
