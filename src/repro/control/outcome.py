"""Whether a closed loop reached its target. Success of the solver is not success of the task."""

from dataclasses import dataclass

import numpy as np

from repro.mechanics.system import System

ANGLE = np.deg2rad(5.0)
POSITION = 0.05  # m
HELD = 2.0  # s


@dataclass(frozen=True)
class Outcome:
    """The result of a closed loop.

    success      erect for all of the last 2 s, and no contact
    contact      a link was inside the disc at some sub-step
    clearance    the least distance of a link to the disc, m; nan without a disc
    held_from    time from which it stayed erect to the end, s; nan where it did not
    steady_error |mean of x - x_des| over the last 2 s, m
    """

    success: bool
    contact: bool
    clearance: float
    held_from: float
    steady_error: float


def judge(time: np.ndarray, states: np.ndarray, clearance: np.ndarray | None, system: System, x_des: float) -> Outcome:
    """The outcome of states (n, 2 n_q) at times (n,) in s, with their clearance (n,) in m, None without a disc.

    States that are not finite (the loop was stopped) are not erect.
    """
    erect = is_erect(states, system, x_des)
    last = time >= time[-1] - HELD - 1e-9
    contact = clearance is not None and bool(np.any(clearance < 0))
    falls = np.flatnonzero(~erect)
    first = falls[-1] + 1 if falls.size else 0
    return Outcome(
        success=bool(np.all(erect[last])) and time[-1] >= HELD and not contact,
        contact=contact,
        clearance=float(np.nanmin(clearance)) if clearance is not None else np.nan,
        held_from=float(time[first]) if first < len(time) else np.nan,
        steady_error=float(abs(np.mean(states[last, 0]) - x_des)),
    )


def is_erect(states: np.ndarray, system: System, x_des: float) -> np.ndarray:
    """Whether every angle is within 5 degrees of upright, modulo a turn, and |x - x_des| < 0.05 m; (n,)."""
    angles = list(system.angles)
    errors = states[..., angles] - system.at_rest()[angles]
    turned = np.abs((errors + np.pi) % (2 * np.pi) - np.pi)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.all(turned < ANGLE, axis=-1) & (np.abs(states[..., 0] - x_des) < POSITION))
