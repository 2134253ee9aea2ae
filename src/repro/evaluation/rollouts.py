"""Predictions over time: one step and many steps, from the states of the test data, under the recorded forces."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from repro.data.dataset import Dataset
from repro.evaluation.model_motion import model_motion
from repro.evaluation.pointwise import MetricValues, finite_or_infinite
from repro.evaluation.predictions import predict
from repro.mechanics.inputs import inputs_from_force, is_constant
from repro.mechanics.system import System
from repro.models.model import Model

LARGEST = 30_000  # weights: above this a roll-out by predictions takes minutes
POINTS = 300  # the test points that Fig. 4 shows
WINDOW_SECONDS = 2.0
WINDOWS = 20
VALID = 0.1  # of the size of the motion: a prediction that is further away is none


@dataclass(frozen=True)
class ModelRollout:
    """Model states along the first test points: (member, point, 2 n_q), restarted from the data at every episode."""

    time: np.ndarray
    plant: np.ndarray
    model: np.ndarray
    one_step_euler: np.ndarray


def can_simulate(model: Model) -> bool:
    """Whether the model has an equation of motion that is quick enough to integrate."""
    return model.not_symbolic is not None or 0 < model.n_parameters <= LARGEST


def _driven(
    model: Model, parameters: np.ndarray, part: Dataset, system: System | None
) -> tuple[np.ndarray, Callable[[np.ndarray, np.ndarray], np.ndarray]]:
    """What is held over each step of a data set, (member, sample, n), and the model's motion under it.

    Held are the inputs of a system whose B depends on q, so that tau changes within a step; otherwise tau. The motion:
    states (member, start, steps + 1, 2 n_q) from (member, start, 2 n_q) under what is held, (member, start, steps, n).
    """
    turned = None if system is None or is_constant(system) else system
    held = part.tau if turned is None else inputs_from_force(turned, part.q, part.tau)
    return held, partial(model_motion, model, parameters, time_step=part.time_step, angles=part.angles, system=turned)


def first_points(model: Model, parameters: np.ndarray, part: Dataset, system: System | None = None) -> ModelRollout:
    """Roll the model out over the first test points, as in Fig. 4."""
    points = min(POINTS, part.samples)
    held, motion = _driven(model, parameters, part, system)
    plant = np.concatenate([part.q, part.qd], axis=-1)[:, :points]
    states = plant.copy()
    restarts = np.flatnonzero(np.diff(part.episode[:points])) + 1
    for start, stop in pairwise([0, *restarts.tolist(), points]):
        states[:, start:stop] = motion(plant[:, None, start], held[:, None, start : stop - 1])[:, 0]
    euler = plant.copy()
    predicted = predict(model, parameters, *(array[:, :points] for array in (part.q, part.qd, part.qdd, part.tau)))
    inside = np.flatnonzero(np.diff(part.episode[:points]) == 0)
    n_q = part.n_q
    euler[:, inside + 1, :n_q] = plant[:, inside, :n_q] + part.time_step * plant[:, inside, n_q:]
    euler[:, inside + 1, n_q:] = plant[:, inside, n_q:] + part.time_step * predicted.acceleration[:, inside]
    return ModelRollout(part.time[:points] - part.time[0], plant, states, euler)


def rollout_errors(rollout: ModelRollout, part: Dataset) -> Iterator[MetricValues]:
    """Mean errors of velocities over the first test points: open loop, and one explicit Euler step (C5)."""
    for component, coordinate in enumerate(part.coordinates):
        column = part.n_q + component
        unit = coordinate.rate_unit
        for name, states in (("rollout_qd", rollout.model), ("onestep_euler_qd", rollout.one_step_euler)):
            error = finite_or_infinite(np.abs(states[..., column] - rollout.plant[..., column]))
            yield MetricValues("test", f"{name}[{component}]", error.mean(1), unit)


def one_step_errors(
    model: Model, parameters: np.ndarray, part: Dataset, system: System | None = None
) -> Iterator[MetricValues]:
    """Mean errors of velocities after one sample time of the model's exact flow, over the first test points."""
    inside = np.flatnonzero(np.diff(part.episode[: min(POINTS, part.samples)]) == 0)
    if not len(inside):
        return
    states = np.concatenate([part.q, part.qd], axis=-1)
    held, motion = _driven(model, parameters, part, system)
    following = motion(states[:, inside], held[:, inside, None])[:, :, 1]
    error = finite_or_infinite(np.abs(following - states[:, inside + 1]))
    for component, coordinate in enumerate(part.coordinates):
        unit = coordinate.rate_unit
        yield MetricValues("test", f"onestep_exact_qd[{component}]", error[..., part.n_q + component].mean(1), unit)


def window_error(
    model: Model, parameters: np.ndarray, part: Dataset, system: System | None = None
) -> Iterator[MetricValues]:
    """Relative error over 2 s windows, as Finzi et al. (2020): the geometric mean of |z - z'| / (|z| + |z'|).

    z = (x - x0, cos theta, sin theta, qd). Beside it the mean time until |z - z'| first exceeds VALID of the rms of
    |z|, at most the window, and the share of windows in which the model diverges.
    """
    steps = round(WINDOW_SECONDS / part.time_step)
    fits = np.flatnonzero(part.episode[: max(0, part.samples - steps)] == part.episode[steps:])
    if not len(fits):
        return
    starts = fits[np.linspace(0, len(fits) - 1, min(WINDOWS, len(fits))).astype(int)]
    states = np.concatenate([part.q, part.qd], axis=-1)
    true = np.stack([states[:, s : s + steps + 1] for s in starts], axis=1)
    held, motion = _driven(model, parameters, part, system)
    rolled = motion(true[:, :, 0], np.stack([held[:, s : s + steps] for s in starts], axis=1))
    z, z_hat = (_embedded(array, true[:, :, :1], part)[:, :, 1:] for array in (true, rolled))
    distance = np.linalg.norm(z - z_hat, axis=-1)
    relative = distance / (np.linalg.norm(z, axis=-1) + np.linalg.norm(z_hat, axis=-1))
    relative = np.where(np.isfinite(relative), np.maximum(relative, 1e-16), 1.0)
    yield MetricValues("test", "rollout_error", np.exp(np.log(relative).mean((1, 2))), "1")
    size = np.sqrt((z**2).sum(-1).mean((1, 2), keepdims=True))
    beyond = np.pad(~(distance <= VALID * size), ((0, 0), (0, 0), (0, 1)), constant_values=True)
    yield MetricValues("test", "valid_time", beyond.argmax(-1).mean(1) * part.time_step, "s")
    yield MetricValues("test", "rollout_diverged", 1.0 - np.isfinite(distance).all(-1).mean(1), "1")


def _embedded(states: np.ndarray, start: np.ndarray, part: Dataset) -> np.ndarray:
    columns = []
    for index, coordinate in enumerate(part.coordinates):
        value = states[..., index]
        columns += [np.cos(value), np.sin(value)] if coordinate.is_angle else [value - start[..., index]]
    return np.concatenate([np.stack(columns, axis=-1), states[..., part.n_q :]], axis=-1)
