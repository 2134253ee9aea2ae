"""The disturbances of a closed loop: start, mismatch of model or plant, and measurement noise."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Lt

from repro.mechanics.system import System
from repro.plugins.options import NotNegative, Options

# random starts: around the cart at 0 and all links hanging
POSITION, ANGLE, SPEED = 0.3, 0.6, 0.3
# one unit of noise: standard deviations of position, angle and their rates
NOISE = (1e-3, 1e-3, 5e-3, 1e-2)

MismatchKind = Literal["coefficients", "physical"]


@dataclass(frozen=True, kw_only=True)
class Conditions(Options):
    """Disturbances of a closed loop.

    mismatch     d: each coefficient of the model (or each mass and length of the plant) times its own U(1 - d, 1 + d)
    noise        of every measurement, in units of NOISE
    disturbance  standard deviation of a random force that is added to that of the controller and held over each step, N
    delay        between measurement and force, s; less than a step
    damping      of the plant's joints in the loop, unknown to every model, as System.damping; empty: that of the system
    """

    mismatch: Annotated[float, Ge(0), Lt(1)] = 0.0
    mismatch_kind: MismatchKind = "coefficients"
    noise: NotNegative = 0.0
    disturbance: NotNegative = 0.0
    delay: NotNegative = 0.0
    damping: tuple[NotNegative, ...] = ()


@dataclass(frozen=True)
class Start:
    """The start of one closed loop: name, initial state (2 n_q,), target x_des in m, and the seed of its noise."""

    name: str
    state: np.ndarray
    x_des: float
    seed: tuple[int, ...]


def hanging_start(system: System, x_des: float) -> Start:
    """The start of the paper: cart at 0, every angle pi, at rest."""
    state = np.zeros(2 * system.n_q)
    state[list(system.angles)] = np.pi
    return Start("hanging", state, x_des, (0, 0))


def random_start(system: System, x_des: float, seed: int, number: int) -> Start:
    """One of many starts around hanging; it depends on its number, not on how many there are."""
    generator = np.random.default_rng([seed, number])
    spread = np.array([ANGLE if c.is_angle else POSITION for c in system.coordinates] + [SPEED] * system.n_q)
    centre = hanging_start(system, 0.0).state
    state = centre + spread * generator.uniform(-1, 1, 2 * system.n_q)
    return Start(f"random {number}", state, x_des, (seed, number))


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
        names = [name for name in system.constants() if name not in ("g", "n")]
        factors = _factors(conditions, start, len(names))
        changed = {name: getattr(system, name) * factor for name, factor in zip(names, factors, strict=True)}
    return replace(system, damping=tuple(damping), **changed)  # type: ignore[arg-type]


def measured(states: np.ndarray, system: System, noise: float, generator: np.random.Generator) -> np.ndarray:
    """States (..., 2 n_q) with measurement noise, in units of NOISE."""
    if not noise:
        return states
    deviations = [NOISE[1] if c.is_angle else NOISE[0] for c in system.coordinates]
    deviations += [NOISE[3] if c.is_angle else NOISE[2] for c in system.coordinates]
    return states + noise * np.array(deviations) * generator.standard_normal(states.shape)


def _factors(conditions: Conditions, start: Start, count: int) -> np.ndarray:
    generator = np.random.default_rng([*start.seed, 1])
    return generator.uniform(1 - conditions.mismatch, 1 + conditions.mismatch, count)
