"""What a controller meets in the loop: where it starts, how wrong its model is, what it measures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from repro.mechanics.system import System

# random starts: around the cart at 0 and all links hanging
POSITION, ANGLE, SPEED = 0.3, 0.6, 0.3
# one unit of noise: standard deviations of position, angle and their rates
NOISE = (1e-3, 1e-3, 5e-3, 1e-2)

MismatchKind = Literal["coefficients", "physical"]


@dataclass(frozen=True)
class Conditions:
    """What disturbs a closed loop.

    mismatch   d: each coefficient of the model (or each mass and length of the plant) times its own U(1 - d, 1 + d)
    noise      in units of NOISE, on every measurement
    disturbance  standard deviation of a force on the cart besides, held over each step, N
    delay      between measurement and force, s; less than a step
    damping    of the plant's joints besides, which no model was told of; as System.damping
    """

    mismatch: float = 0.0
    mismatch_kind: MismatchKind = "coefficients"
    noise: float = 0.0
    disturbance: float = 0.0
    delay: float = 0.0
    damping: tuple[float, ...] = ()


@dataclass(frozen=True)
class Start:
    """One closed loop: its name, the initial state (2 n_q,), where to go, and the stream of its random numbers."""

    name: str
    state: np.ndarray
    x_des: float
    seed: tuple[int, ...]


def hanging_start(system: System, x_des: float) -> Start:
    """The paper's: cart at 0, every angle pi, at rest."""
    state = np.zeros(2 * system.n_q)
    state[list(system.angles)] = np.pi
    return Start("hanging", state, x_des, (0, 0))


def random_starts(system: System, x_des: Sequence[float], count: int, seed: int) -> list[Start]:
    """Starts around hanging, x_des in turn; start k is the same whatever the count."""
    made = []
    for k in range(count):
        generator = np.random.default_rng([seed, k])
        spread = np.array([ANGLE if c.is_angle else POSITION for c in system.coordinates] + [SPEED] * system.n_q)
        centre = hanging_start(system, 0.0).state
        state = centre + spread * generator.uniform(-1, 1, 2 * system.n_q)
        made.append(Start(f"random {k}", state, float(x_des[k % len(x_des)]), (seed, k)))
    return made


def wrong_weights(weights: np.ndarray, conditions: Conditions, start: Start) -> np.ndarray:
    """The model's weights under mismatch of its coefficients, drawn anew for every start."""
    if conditions.mismatch_kind != "coefficients":
        return weights
    return np.asarray(weights * _factors(conditions, start, len(weights)))


def plant_of(system: System, conditions: Conditions, start: Start) -> System:
    """The true plant of one closed loop: its friction, and under physical mismatch its own masses and lengths."""
    damping = conditions.damping or system.damping
    changed: dict[str, float] = {}
    if conditions.mismatch_kind == "physical" and conditions.mismatch:
        names = [name for name in system.constants() if name not in ("g", "n")]
        factors = _factors(conditions, start, len(names))
        changed = {name: getattr(system, name) * factor for name, factor in zip(names, factors, strict=True)}
    return replace(system, damping=tuple(damping), **changed)  # type: ignore[arg-type]


def measured(states: np.ndarray, system: System, noise: float, generator: np.random.Generator) -> np.ndarray:
    """States (..., 2 n_q) with noise."""
    if not noise:
        return states
    deviations = [NOISE[1] if c.is_angle else NOISE[0] for c in system.coordinates]
    deviations += [NOISE[3] if c.is_angle else NOISE[2] for c in system.coordinates]
    return states + noise * np.array(deviations) * generator.standard_normal(states.shape)


def _factors(conditions: Conditions, start: Start, count: int) -> np.ndarray:
    generator = np.random.default_rng([*start.seed, 1])
    return generator.uniform(1 - conditions.mismatch, 1 + conditions.mismatch, count)
