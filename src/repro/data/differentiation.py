"""Velocities and accelerations from samples, by differences and by local polynomials."""

import numpy as np

from repro.errors import UserError

ORDER = 4  # of the polynomials
SECONDS = 0.2  # that one of them spans, at least LEAST samples
LEAST = 7


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


def savitzky_golay(
    q: np.ndarray, qd: np.ndarray | None, time: np.ndarray, episode: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, qd, qdd (..., sample, n_q) by least-squares polynomials (Savitzky and Golay 1964), of q or of q and qd.

    Even sampling is assumed within an episode; one shorter than a polynomial has a polynomial of its own length.
    """
    from scipy.signal import savgol_filter

    sources = [(q, 0), (q, 1), (q, 2)] if qd is None else [(q, 0), (qd, 0), (qd, 1)]
    found = [np.empty_like(q) for _ in range(3)]
    for rows in np.split(np.arange(len(episode)), np.flatnonzero(np.diff(episode)) + 1):
        if len(rows) < 3:
            raise UserError(f"episode {episode[rows[0]]} has {len(rows)} samples: a polynomial needs 3; make it longer")
        step = float(np.median(np.diff(time[rows])))
        wanted = max(LEAST, round(SECONDS / step))
        window = min(wanted, len(rows)) - (min(wanted, len(rows)) + 1) % 2
        order = min(ORDER, window - 1)

        for number, (values, derivative) in enumerate(sources):
            found[number][..., rows, :] = savgol_filter(
                values[..., rows, :], window, order, deriv=derivative, delta=step, axis=-2
            )
    return found[0], found[1], found[2]


def differences_of_positions(q: np.ndarray, time: np.ndarray, episode: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities and accelerations of positions q (sample, n_q), from the parabola through three neighbours.

    Of second and first order in the uneven steps of time (sample,); the ends of an episode take the parabola of their
    neighbour. episode: (sample,), each of at least three samples.
    """
    qd, qdd = np.empty_like(q), np.empty_like(q)
    for part in np.split(np.arange(len(q)), np.flatnonzero(np.diff(episode)) + 1):
        before, after = np.diff(time[part])[:-1, None], np.diff(time[part])[1:, None]
        left, right = np.diff(q[part], axis=0)[:-1] / before, np.diff(q[part], axis=0)[1:] / after
        curve = 2 * (right - left) / (before + after)
        slope = (after * left + before * right) / (before + after)
        qdd[part] = np.concatenate([curve[:1], curve, curve[-1:]])
        qd[part] = np.concatenate([slope[:1] - before[0] * curve[:1], slope, slope[-1:] + after[-1] * curve[-1:]])
    return qd, qdd
