"""Theorem 1 as a number: the worst passivity margin of a model over random states."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.lazy_torch import torch
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.system import System
from repro.models.model import Model, acceleration

REACH = 2.0  # m on either side of the start
FASTEST = 3.0  # times the spread of the training velocities
FORCE = 5.0  # N and N m


@dataclass(frozen=True)
class States:
    """Random states and inputs at which passivity is checked; each (state, n_q)."""

    q: np.ndarray
    qd: np.ndarray
    tau: np.ndarray

    @classmethod
    def random(
        cls, coordinates: Sequence[Coordinate], velocity_scale: np.ndarray, count: int, generator: np.random.Generator
    ) -> "States":
        """Uniform over the whole turn of every angle, velocities well beyond those of the data, and all inputs."""
        reach = np.array([np.pi if coordinate.is_angle else REACH for coordinate in coordinates])
        draw = generator.uniform(-1, 1, (3, count, len(reach)))
        return cls(draw[0] * reach, draw[1] * FASTEST * velocity_scale, draw[2] * FORCE)


def worst_margin(model: Model, parameters: np.ndarray, states: States, storage: System | None = None) -> np.ndarray:
    """Largest (dH/dt - y'u) / (|y'u| + |grad H| |xdot|) over the states, (member,); above 0 the model makes energy.

    H and xdot are the model's own, in x = [q; p]; with `storage` H is the true system's, in x = [q; qd].
    """
    return np.array([margins(model, weights, states, storage).max() for weights in parameters])


def margins(model: Model, weights: np.ndarray, states: States, storage: System | None = None) -> np.ndarray:
    """The passivity margin (state,) at all states, for one member's weights (n_parameters,); nan where xdot is."""
    q, qd, tau = states.q, states.qd, states.tau
    if storage is None:
        gradient, drift = model.port_values(weights, q, qd)
        rate, velocity = drift + np.concatenate([np.zeros_like(tau), tau], axis=-1), gradient[..., model.n_q :]
    else:
        gradient, velocity = evaluate(_energy_gradient(storage), q, qd), qd
        rate = np.concatenate([qd, _accelerations(model, weights, states)], axis=-1)
    supplied = (velocity * tau).sum(-1)
    with np.errstate(invalid="ignore", over="ignore"):  # accelerations are infinite where the mass matrix is singular
        size = np.linalg.norm(gradient, axis=-1) * np.linalg.norm(rate, axis=-1) + np.abs(supplied)
        gained = (gradient * rate).sum(-1) - supplied
        margin: np.ndarray = np.divide(gained, size, out=np.zeros_like(size), where=size > 0)
    return margin


def _accelerations(model: Model, weights: np.ndarray, states: States) -> np.ndarray:
    if model.not_symbolic is None:
        return evaluate(acceleration(model), states.q, states.qd, states.tau, weights)
    samples = [array[None] for array in (states.q, states.qd, states.tau)]
    (found,) = model.accelerations(torch.from_numpy(weights)[None], *samples)
    return np.asarray(found)


@lru_cache(maxsize=16)
def _energy_gradient(system: System) -> casadi.Function:
    """[dH/dq | dH/dqd] of T + V."""
    q, qd = (casadi.SX.sym(name, system.n_q) for name in ("q", "qd"))
    components, rates = casadi.vertsplit(q), casadi.vertsplit(qd)
    energy = casadi.SX(system.kinetic(components, rates, casadi) + system.potential(components, casadi))
    return column_function("energy_gradient", [q, qd], casadi.gradient(energy, q), casadi.gradient(energy, qd))
