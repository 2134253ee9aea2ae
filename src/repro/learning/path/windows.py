"""A member's recording cut into short windows side by side, and the steps from sample to sample within them."""

from dataclasses import dataclass

import numpy as np

from repro.data.dataset import Dataset

GAP = 4.0  # median sampling intervals: a longer one ends a window, for the force is not known there


@dataclass(frozen=True)
class Windows:
    """Windows of unequal length, padded: row and column (sample,) are the place of every sample.

    measured: (window, position, n_y), NaN where nothing is recorded; step: (window, position) s to the next sample,
    NaN at the end of a window; variance: (n_y,) of the sensors; force_variance: (n_q,); n_q.
    """

    row: np.ndarray
    column: np.ndarray
    measured: np.ndarray
    step: np.ndarray
    variance: np.ndarray
    force_variance: np.ndarray
    n_q: int

    @classmethod
    def of(cls, dataset: Dataset, member: int, length: float) -> "Windows":
        """The training part of a member in windows of at most `length` s."""
        recorded, time = dataset.measurement, dataset.time
        assert recorded is not None
        interval = float(np.median(np.diff(time)))
        most = max(2, round(length / interval))
        breaks = (np.diff(dataset.episode) != 0) | (np.diff(time) > GAP * interval)
        starts = np.append(0, np.flatnonzero(breaks) + 1)
        within = np.arange(len(time)) - np.repeat(starts, np.diff(np.append(starts, len(time))))
        column = within % most
        row = np.cumsum(column == 0) - 1
        shape = (int(row[-1]) + 1, int(column.max()) + 1)
        parts = [recorded.q[member], *([] if recorded.qd is None else [recorded.qd[member]])]
        measured = np.full((*shape, len(parts) * dataset.n_q), np.nan)
        measured[row, column] = np.concatenate(parts, axis=1)
        clock = np.full(shape, np.nan)
        clock[row, column] = time
        noises = [recorded.q_noise, *([] if recorded.qd is None else [recorded.qd_noise])]
        known = np.concatenate([np.ones(dataset.n_q) if noise is None else noise for noise in noises])
        force = np.zeros(dataset.n_q) if recorded.tau_noise is None else recorded.tau_noise
        step = np.diff(clock, axis=1, append=np.nan)
        return cls(row, column, measured, step, np.maximum(known, 1e-6) ** 2, force**2, dataset.n_q)

    def cut(self, values: np.ndarray) -> np.ndarray:
        """Samples (sample, k) in their places (window, position, k), 0 elsewhere."""
        placed = np.zeros((*self.step.shape, values.shape[1]))
        placed[self.row, self.column] = values
        return placed

    @property
    def count(self) -> int:
        """Recorded numbers, less those that the unknown states at the start of the windows take up."""
        return int(np.isfinite(self.measured).sum()) - 2 * self.n_q * len(self.measured)
