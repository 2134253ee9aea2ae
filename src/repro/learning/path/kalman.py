"""The whitened Kalman filter over "deviation from the path + one column per weight", and the smoother behind it.

The state x_k + d_k obeys d_{k+1} = A d_k + B dw + c + U du + e. Filtering the columns of B beside c turns the noisy
regression for dw into one with independent rows of unit variance, in which the path has been eliminated exactly.
Sensors are taken one after the other, and the smoother needs no inverse (Durbin and Koopman 2012, 6.4).
"""

from dataclasses import dataclass, replace

import numpy as np

from repro.learning.path.windows import Windows

Update = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Linearised:
    """The motion near a path: states (window, position, 2 n_q), and of every step A, U, and columns [c | B].

    by_state: (window, position, 2 n_q, 2 n_q); by_force: (.., 2 n_q, n_q); columns: (.., 2 n_q, 1 + n_weights). process
    noise: (2 n_q,) variances of every step.
    """

    states: np.ndarray
    by_state: np.ndarray
    by_force: np.ndarray
    columns: np.ndarray
    process: np.ndarray


def whitened(windows: Windows, linear: Linearised, initial: np.ndarray) -> np.ndarray:
    """Rows [e | E] (n_rows, 1 + n_weights), zero where nothing is recorded: the residuals are e + E dw.

    initial: (2 n_q,) variances of the state at the start of a window.
    """
    rows, _ = _filtered(windows, linear, initial)
    return rows.reshape(-1, rows.shape[-1])


@dataclass(frozen=True)
class SmoothedPath:
    """Deviations (window, position, 2 n_q), force errors (window, position, n_q), and the loss of the filter."""

    deviations: np.ndarray
    force_errors: np.ndarray


def smoothed(windows: Windows, linear: Linearised, change: np.ndarray, initial: np.ndarray) -> SmoothedPath:
    """The most likely path after a change (n_weights,) of the weights."""
    moved = linear.columns[..., :1] + (linear.columns[..., 1:] @ change)[..., None]
    _, kept = _filtered(windows, replace(linear, columns=moved), initial)
    deviations, errors = np.zeros_like(linear.states), np.zeros((*linear.states.shape[:2], windows.n_q))
    pull = np.zeros((len(linear.states), linear.states.shape[2]))
    for k in range(linear.states.shape[1] - 1, -1, -1):
        predicted, spread, updates = kept[k]
        errors[:, k] = windows.force_variance * np.einsum("wxi,wx->wi", linear.by_force[:, k], pull)
        pull = np.einsum("wxy,wx->wy", linear.by_state[:, k], pull)
        for sensor in range(len(updates) - 1, -1, -1):
            scaled, gain = updates[sensor]
            pull[:, sensor] += scaled - (gain * pull).sum(1)
        deviations[:, k] = predicted + np.einsum("wxy,wy->wx", spread, pull)
    return SmoothedPath(deviations, errors)


def _filtered(
    windows: Windows, linear: Linearised, initial: np.ndarray
) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray, list[Update]]]]:
    """Rows (position, sensor, window, column), and the first column's predictions, spreads and updates."""
    count, length, n_x = linear.states.shape
    sensors, columns = windows.measured.shape[2], linear.columns.shape[3]
    rows = np.zeros((length, sensors, count, columns))
    mean = np.zeros((count, n_x, columns))
    spread = np.broadcast_to(np.diag(initial), (count, n_x, n_x)).copy()
    seen = np.isfinite(windows.measured)
    errors = np.where(seen, windows.measured - linear.states[..., :sensors], 0.0)
    process = np.diag(linear.process)
    kept = []
    for k in range(length):
        predicted, before, updates = mean[..., 0].copy(), spread.copy(), list[Update]()
        for sensor in range(sensors):
            here = seen[:, k, sensor]
            size = spread[:, sensor, sensor] + windows.variance[sensor]
            error = -mean[:, sensor]
            error[:, 0] += errors[:, k, sensor]
            error *= here[:, None]
            rows[k, sensor] = error / np.sqrt(size)[:, None]
            gain = spread[:, :, sensor] * (here / size)[:, None]
            mean += gain[:, :, None] * error[:, None]
            spread -= gain[:, :, None] * spread[:, None, sensor]
            updates.append((error[:, 0] / size, gain))
        kept.append((predicted, before, updates))
        if k + 1 < length:
            forward, push = linear.by_state[:, k], linear.by_force[:, k]
            mean = forward @ mean + linear.columns[:, k]
            spread = forward @ spread @ forward.swapaxes(1, 2) + process
            spread += (push * windows.force_variance) @ push.swapaxes(1, 2)
    return rows, kept
