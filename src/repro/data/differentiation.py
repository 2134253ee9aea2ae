"""Accelerations from sampled velocities."""

import numpy as np

from repro.errors import UserError


def difference(qd: np.ndarray, time: np.ndarray, episode: np.ndarray) -> np.ndarray:
    """Forward difference of qd (..., sample, n_q) within each episode, backward for an episode's last sample.

    time: (sample,) s; episode: (sample,), changing where a new one starts. UserError for an episode of one sample.
    """
    continues = episode[1:] == episode[:-1]
    lonely = ~np.append(continues, False) & ~np.append(False, continues)
    if lonely.any():
        raise UserError(
            f"episode {episode[lonely][0]} has a single sample, which has no difference: make episodes longer"
        )
    steps = np.where(continues, np.diff(time), np.inf)
    slope = np.diff(qd, axis=-2) / steps[:, None]
    last = ~np.append(continues, False)
    result = np.concatenate([slope, slope[..., -1:, :]], axis=-2)
    result[..., last, :] = result[..., np.flatnonzero(last) - 1, :]
    return result
