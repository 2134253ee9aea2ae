"""The motion of a learned model: by a compiled simulator, or by predictions alone where it has no symbolic form."""

from collections.abc import Sequence
from functools import lru_cache

import casadi
import numpy as np

from repro.evaluation.predictions import predict
from repro.mechanics.inputs import generalised_force, under_inputs
from repro.mechanics.runge_kutta import rk4_step
from repro.mechanics.simulate import simulate
from repro.mechanics.system import System
from repro.models.model import Model

FEW_STEPS = 1000  # of all trajectories: below this CasADi integrates in less time than a compiler takes
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
    if model.not_symbolic is None:
        motion = acceleration(model) if system is None else under_inputs(acceleration(model), system)
        engine = "casadi" if held.shape[0] * held.shape[1] < FEW_STEPS else "auto"
        return simulate(motion, initial, held, time_step, parameters=weights, angles=angles, engine=engine)
    states = np.empty((len(held), held.shape[1] + 1, initial.shape[1]))
    states[:, 0] = initial
    for step in range(held.shape[1]):

        def rate(state: np.ndarray, inputs: np.ndarray = held[:, step]) -> np.ndarray:
            q, qd = np.split(state, 2, axis=1)
            force = inputs if system is None else generalised_force(system, q, inputs)
            samples = [array[:, None] for array in (q, qd, np.zeros_like(q), force)]
            return np.concatenate([qd, predict(model, weights, *samples).acceleration[:, 0]], axis=1)

        state = states[:, step]
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(SUBSTEPS):
                state = rk4_step(rate, state, time_step / SUBSTEPS)
        states[:, step + 1] = np.where(np.isfinite(state).all(axis=1, keepdims=True), state, np.nan)
    return states


@lru_cache(maxsize=16)
def acceleration(model: Model) -> casadi.Function:
    """qdd = f(q, qd, tau, parameters) of a model, as a CasADi function."""
    q, qd, tau = (casadi.SX.sym(name, model.n_q) for name in ("q", "qd", "tau"))
    parameters = casadi.SX.sym("parameters", model.n_parameters)
    qdd = model.acceleration(q, qd, tau, parameters)
    return casadi.Function("acceleration", [q, qd, tau, parameters], [casadi.densify(qdd)], {"cse": True})
