"""The motion of a learned model: by a compiled simulator, or by predictions alone where it cannot be compiled."""

from collections.abc import Sequence

import numpy as np

from repro.codegen.lazy_torch import torch
from repro.mechanics.inputs import generalised_force, under_inputs
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System
from repro.models.model import Model, acceleration

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
    """States (member, start, steps + 1, 2 n_q) from `initial` (member, start, 2 n_q); weights (member, n_parameters).

    held: over each step of time_step s, tau (member, start, steps, n_q), or the inputs (..., n_u) of `system`.
    Integrated by RK4; not finite from where the motion diverges.
    """
    weights = np.asarray(weights, dtype=float)
    members, starts, steps, _ = held.shape
    if is_compiled(model):
        motion = acceleration(model) if system is None else under_inputs(acceleration(model), system)
        begun, driven = (array.reshape(members * starts, *array.shape[2:]) for array in (initial, held))
        each = np.repeat(weights, starts, axis=0)
        moved = simulate(motion, begun, driven, time_step, parameters=each, angles=angles, engine="cheaper")
        return moved.reshape(members, starts, *moved.shape[1:])
    parameters = torch.from_numpy(weights)
    states = np.empty((steps + 1, *initial.shape))
    states[0] = model.state(initial)
    for step in range(steps):

        def rate(state: np.ndarray, inputs: np.ndarray = held[:, :, step]) -> np.ndarray:
            tau = inputs if system is None else generalised_force(system, state[..., : model.n_q], inputs)
            return model.state_rate(parameters, state, tau)

        state = states[step]
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(SUBSTEPS):
                state = rk4_step(rate, state, time_step / SUBSTEPS)
        states[step + 1] = np.where(np.isfinite(state).all(axis=-1, keepdims=True), state, np.nan)
    moved = np.stack([model.motion_of(parameters, state) for state in states], axis=2)
    moved[:, :, 0] = initial
    return moved


def is_compiled(model: Model) -> bool:
    """Whether the motion of a model is computed by compiled code."""
    return model.not_symbolic is None and model.n_parameters <= LARGEST
