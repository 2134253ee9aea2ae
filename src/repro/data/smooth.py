"""Motion from noisy positions, and velocities where they are recorded: a Kalman smoother without a model of the system.

Every coordinate is the triple integral of white noise (a white-jerk process) with an intensity of maximum likelihood.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from repro.data.dataset import EXACT, Measurement

INTENSITIES = 10.0 ** np.arange(0, 9)  # (m/s^3)^2 s: decades that are compared
RATIOS = 10.0 ** np.arange(0, 17)  # of an intensity to the variance of a sensor
TRIED = 6  # episodes, and of each so many samples, on which the likelihood is compared
TRIED_SAMPLES = 300
PRIOR = np.array([1.0, 1e3, 1e6])  # variances of position, velocity and acceleration at the start of an episode

Motions = Sequence[tuple[np.ndarray, np.ndarray]]


def smooth(
    measured: Measurement, time: np.ndarray, episode: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Measurement]:
    """q, qd, qdd (member, sample, n_q), and the record with the noise of the sensors, given or of maximum likelihood.

    Every episode is smoothed for itself; time (sample,) s may be uneven, and samples that are NaN are skipped. Noise
    that is not given is estimated: one value per coordinate, the median of the members'.
    """
    members, _, n_q = measured.q.shape
    blocks = _Blocks(time, episode)
    position = blocks.cut(measured.q)
    velocity = np.full_like(position, np.nan) if measured.qd is None else blocks.cut(measured.qd)
    few, short = slice(None, TRIED), slice(None, TRIED_SAMPLES)
    part = position[few, short], velocity[few, short], _motions(blocks.steps[few, short])
    position_noise = _noise(measured.q_noise, part[0], np.full_like(part[0], np.nan), part[2], n_q)
    velocity_noise = None
    if measured.qd is not None:
        velocity_noise = _noise(measured.qd_noise, np.full_like(part[1], np.nan), part[1], part[2], n_q)
    both = (position_noise, velocity_noise)
    noises = np.stack([np.ones(n_q) if each is None else np.maximum(each, EXACT) for each in both])
    variances = np.tile(noises**2, members)
    losses = np.stack([_Filter(*part, variances, np.full(members * n_q, each)).loss for each in INTENSITIES])
    intensity = INTENSITIES[losses.argmin(0)]
    states = _Filter(position, velocity, _motions(blocks.steps), variances, intensity).smoothed()
    q, qd, qdd = (blocks.join(states[..., order], members) for order in range(3))
    return q, qd, qdd, replace(measured, q_noise=position_noise, qd_noise=velocity_noise)


def _noise(
    given: np.ndarray | None, position: np.ndarray, velocity: np.ndarray, motions: Motions, n_q: int
) -> np.ndarray:
    """The standard deviation of one sensor (n_q,): beside the variance 1 the best scale is in closed form."""
    if given is not None:
        return given
    ones, prior = np.ones((2, position.shape[2])), PRIOR / EXACT
    tried = [_Filter(position, velocity, motions, ones, np.full(position.shape[2], ratio), prior) for ratio in RATIOS]
    concentrated = np.stack([filtered.concentrated for filtered in tried])
    variances = np.stack([filtered.variance for filtered in tried])
    best = np.take_along_axis(variances, concentrated.argmin(0)[None], 0)[0]
    return np.asarray(np.median(np.sqrt(best).reshape(-1, n_q), axis=0))


class _Blocks:
    """Episodes side by side: (episode, sample, series), padded with NaN; a series is a coordinate of a member."""

    def __init__(self, time: np.ndarray, episode: np.ndarray) -> None:
        starts = np.flatnonzero(np.append(True, np.diff(episode) != 0))
        lengths = np.diff(np.append(starts, len(episode)))
        self.row = np.repeat(np.arange(len(starts)), lengths)
        self.column = np.arange(len(episode)) - np.repeat(starts, lengths)
        self.shape = (len(starts), int(lengths.max()))
        clock = np.full(self.shape, np.nan)
        clock[self.row, self.column] = time
        steps = np.diff(clock, axis=1, append=np.nan)
        self.steps = np.where(np.isfinite(steps), steps, 1.0)  # s to the next sample; any where there is none

    def cut(self, array: np.ndarray) -> np.ndarray:
        blocks = np.full((*self.shape, array.shape[0] * array.shape[2]), np.nan)
        blocks[self.row, self.column] = array.transpose(1, 0, 2).reshape(array.shape[1], -1)
        return blocks

    def join(self, blocks: np.ndarray, members: int) -> np.ndarray:
        flat = blocks[self.row, self.column]
        return np.ascontiguousarray(flat.reshape(len(flat), members, -1).transpose(1, 0, 2))


class _Filter:
    """The Kalman filter of all series at once, one sample of every episode after the other.

    position, velocity: (episode, sample, series); motions: of each sample, to the next one; variances: (2, series) of
    the two sensors; intensity: (series,); prior: variances (3,) at the start. `loss`: -2 log likelihood (series,),
    without a constant.
    """

    def __init__(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        motions: Motions,
        variances: np.ndarray,
        intensity: np.ndarray,
        prior: np.ndarray = PRIOR,
    ) -> None:
        episodes, samples, series = position.shape
        self.motions, self.measured = motions, (position, velocity)
        state = np.zeros((episodes, series, 3))
        for order, values in enumerate(self.measured):
            first = np.isfinite(values).argmax(1)
            state[..., order] = np.nan_to_num(np.take_along_axis(values, first[:, None], 1)[:, 0])
        covariance = np.broadcast_to(np.diag(prior), (episodes, series, 3, 3)).copy()
        self.squares, self.logs, self.count = np.zeros((3, series))
        kept: list[tuple[np.ndarray, np.ndarray, list[tuple[np.ndarray, np.ndarray]]]] = []
        for k in range(samples):
            predicted, spread, updates = state, covariance, []
            for order, values in enumerate(self.measured):
                seen = np.isfinite(values[:, k])
                error = np.where(seen, values[:, k] - state[..., order], 0.0)
                size = covariance[..., order, order] + variances[order]
                gain = np.where(seen[..., None], covariance[..., order] / size[..., None], 0.0)
                self.squares += (error**2 / size).sum(0)
                self.logs += np.where(seen, np.log(size), 0.0).sum(0)
                self.count += seen.sum(0)
                state = state + gain * error[..., None]
                covariance = covariance - gain[..., None] * covariance[..., order, None, :]
                updates.append((error / size, gain))
            kept.append((predicted, spread, updates))
            transition, noise = motions[k]
            state = (transition[:, None] @ state[..., None])[..., 0]
            covariance = transition[:, None] @ covariance @ transition.swapaxes(-1, -2)[:, None]
            covariance = covariance + noise[:, None] * intensity[:, None, None]
        self._kept = kept

    @property
    def loss(self) -> np.ndarray:
        return np.asarray(self.squares + self.logs)

    @property
    def variance(self) -> np.ndarray:
        """The factor (series,) of all variances that is most likely."""
        return np.asarray(self.squares / self.count)

    @property
    def concentrated(self) -> np.ndarray:
        """-2 log likelihood (series,) at that factor."""
        return np.asarray(self.count * np.log(self.variance) + self.logs)

    def smoothed(self) -> np.ndarray:
        """States (episode, sample, series, 3) given all samples, without an inverse (Durbin and Koopman 2012)."""
        _, samples, _ = self.measured[0].shape
        found = np.empty((*self.measured[0].shape, 3))
        pull = np.zeros((*found.shape[:1], *found.shape[2:]))
        for k in range(samples - 1, -1, -1):
            predicted, spread, updates = self._kept[k]
            transition, _ = self.motions[k]
            pull = (transition.swapaxes(-1, -2)[:, None] @ pull[..., None])[..., 0]
            for order in (1, 0):
                scaled, gain = updates[order]
                pull[..., order] += scaled - (gain * pull).sum(-1)
            found[:, k] = predicted + (spread @ pull[..., None])[..., 0]
        return found


def _motions(steps: np.ndarray) -> Motions:
    """Of each sample: transition (episode, 3, 3) over steps (episode, sample) s, and covariance of unit white jerk."""
    h, zero = steps, np.zeros_like(steps)
    one = zero + 1
    rows = [[one, h, h**2 / 2], [zero, one, h], [zero, zero, one]]
    noise = [[h**5 / 20, h**4 / 8, h**3 / 6], [h**4 / 8, h**3 / 3, h**2 / 2], [h**3 / 6, h**2 / 2, h]]
    # The entries of a matrix lie apart: products of matrices in another order of memory are rounded otherwise.
    transitions, spreads = (np.ascontiguousarray(np.moveaxis(np.array(each), -1, 0)) for each in (rows, noise))
    return [
        (np.moveaxis(transition, -1, 0), np.moveaxis(spread, -1, 0))
        for transition, spread in zip(transitions, spreads, strict=True)
    ]
