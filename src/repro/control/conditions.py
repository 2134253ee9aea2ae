"""The disturbances of a closed loop: mismatch of model or plant, and measurement noise."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Lt

from repro.control.goal import Goal
from repro.mechanics.system import System
from repro.plugins.options import NotNegative, Options

# one unit of noise: standard deviations of position, angle and their rates
NOISE = (1e-3, 1e-3, 5e-3, 1e-2)

MismatchKind = Literal["coefficients", "physical"]


@dataclass(frozen=True, kw_only=True)
class Conditions(Options):
    """Disturbances of a closed loop: what each is stands in conf/task/_base.yaml."""

    mismatch: Annotated[float, Ge(0), Lt(1)] = 0.0
    mismatch_kind: MismatchKind = "coefficients"
    noise: NotNegative = 0.0
    disturbance: NotNegative = 0.0
    delay: NotNegative = 0.0
    damping: tuple[NotNegative, ...] = ()


@dataclass(frozen=True)
class Start:
    """The start of one closed loop: name, initial state (2 n_q,), goal, and the seed of its noise."""

    name: str
    state: np.ndarray
    goal: Goal
    seed: tuple[int, ...]


def wrong_weights(weights: np.ndarray, conditions: Conditions, start: Start) -> np.ndarray:
    """The model's weights (n_parameters,) under mismatch of its coefficients, drawn anew for every start."""
    if conditions.mismatch_kind != "coefficients":
        return weights
    return np.asarray(weights * _factors(conditions, start, len(weights)))


def plant_of(system: System, conditions: Conditions, start: Start) -> System:
    """The true plant of one closed loop: its friction, and under physical mismatch its own masses and lengths."""
    damping = conditions.damping or system.damping
    changed: dict[str, float] = {}
    if conditions.mismatch_kind == "physical" and conditions.mismatch:
        names = [name for name in system.constants() if name != "g" and name not in system.counts]
        factors = _factors(conditions, start, len(names))
        changed = {name: getattr(system, name) * factor for name, factor in zip(names, factors, strict=True)}
    return replace(system, damping=tuple(damping), **changed)  # type: ignore[arg-type]


def measured(states: np.ndarray, system: System, noise: float, generator: np.random.Generator) -> np.ndarray:
    """States (..., 2 n_q) with measurement noise, in units of NOISE."""
    if not noise:
        return states
    return states + noise * sensor_errors(system) * generator.standard_normal(states.shape)


def sensor_errors(system: System) -> np.ndarray:
    """Standard deviations (2 n_q,) of one unit of noise."""
    deviations = [NOISE[1] if c.is_angle else NOISE[0] for c in system.coordinates]
    deviations += [NOISE[3] if c.is_angle else NOISE[2] for c in system.coordinates]
    return np.array(deviations)


def _factors(conditions: Conditions, start: Start, count: int) -> np.ndarray:
    generator = np.random.default_rng([*start.seed, 1])
    return generator.uniform(1 - conditions.mismatch, 1 + conditions.mismatch, count)
