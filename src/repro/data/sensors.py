"""What sensors record of a simulated motion, and the estimates of the motion that are made from it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset, Measurement
from repro.data.differentiation import difference, savitzky_golay
from repro.data.smooth import smooth
from repro.mechanics.inputs import generalised_force, input_matrix
from repro.mechanics.system import System

Streams = Sequence[Mapping[str, np.random.Generator]]


@dataclass(frozen=True)
class Sensors:
    """Of the training part alone; options: what is measured, with which errors, and how the rest is made."""

    options: RandomForce

    def record(self, exact: Dataset, streams: Streams, system: System) -> Dataset:
        """The data with a recorded training part; one stream of each purpose per member."""
        train, labels, noise = exact.train, self.options.labels, self.options.noise
        tau = self._noisy("tau", train.tau, streams)
        if noise["force"]:
            still = np.zeros((*train.tau.shape[:2], len(system.inputs)))
            tau = tau + generalised_force(system, train.q, self._noisy("force", still, streams))
        q = self._encoded(self._noisy("q", train.q, streams), train)
        qd = self._noisy("qd", train.qd, streams)
        if self.options.measured == "accelerations" and labels in ("exact", "differenced"):
            qdd = difference(qd, train.time, train.episode) if labels == "differenced" else train.qdd
            return _with_train(exact, q=q, qd=qd, qdd=self._noisy("qdd", qdd, streams), tau=tau)
        leverage = np.sqrt((input_matrix(system, train.q) ** 2).sum(-1).reshape(-1, train.n_q).mean(0))
        # rounding is uniform: a variance of step^2 / 12
        rounding = self._steps(train) ** 2 / 12 if self.options.quantisation else 0.0
        position_noise = np.sqrt(np.full(train.n_q, noise["q"]) ** 2 + rounding)
        force_noise = np.hypot(noise["tau"], noise["force"] * leverage)
        recorded = Measurement(q, q_noise=position_noise, tau_noise=force_noise)
        if self.options.measured != "positions":
            recorded = replace(recorded, qd=qd, qd_noise=np.full(train.n_q, noise["qd"]))
        whole = _with_train(exact, q=recorded.q, qd=qd)
        whole_record = replace(recorded, q=whole.q, qd=None if recorded.qd is None else whole.qd)
        q, qd, qdd, _ = estimated(recorded, train.time, train.episode, labels)
        return replace(_with_train(exact, q=q, qd=qd, qdd=qdd, tau=tau), measurement=whole_record)

    def _noisy(self, name: str, values: np.ndarray, streams: Streams) -> np.ndarray:
        if not (deviation := self.options.noise[name]):
            return values
        draws = np.stack([stream[name].standard_normal(values.shape[1:]) for stream in streams])
        return np.asarray(values + deviation * draws)

    def _encoded(self, q: np.ndarray, train: Dataset) -> np.ndarray:
        """Positions as encoders show them, turns counted again where they were lost."""
        angles = np.array([coordinate.is_angle for coordinate in train.coordinates])
        if self.options.encoder_zero:
            q = q + self.options.encoder_zero * angles
        if self.options.quantisation:
            step = self._steps(train)
            q = np.where(step > 0, np.round(q / np.where(step > 0, step, 1)) * step, q)
        if self.options.wrapped:
            turned = np.where(angles, np.pi - np.mod(np.pi - q, 2 * np.pi), q)
            q = unwrapped(turned, train.angles, train.episode)
        return q

    def _steps(self, train: Dataset) -> np.ndarray:
        return np.array([self.options.quantisation[coordinate.is_angle] for coordinate in train.coordinates])


def estimated(
    recorded: Measurement, time: np.ndarray, episode: np.ndarray, labels: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray, Measurement]:
    """q, qd, qdd (member, sample, n_q) by the method of `labels`, and the record with the noise that was assumed."""
    if labels == "smoothed":
        return smooth(recorded, time, episode)
    if labels == "savitzky_golay":
        return (*savitzky_golay(recorded.q, recorded.qd, time, episode), recorded)
    qd = difference(recorded.q, time, episode) if recorded.qd is None else recorded.qd
    return recorded.q, qd, difference(qd, time, episode), recorded


def unwrapped(q: np.ndarray, angles: Sequence[int], episode: np.ndarray) -> np.ndarray:
    """Angles (..., sample, n_q) without jumps of a turn within an episode."""
    q = q.copy()
    for rows in np.split(np.arange(len(episode)), np.flatnonzero(np.diff(episode)) + 1):
        for angle in angles:
            q[..., rows, angle] = np.unwrap(q[..., rows, angle], axis=-1)
    return q


def _with_train(exact: Dataset, **train: np.ndarray) -> Dataset:
    """The dataset with other arrays of its training part, by name."""
    test = exact.test
    whole = {name: np.concatenate([values, getattr(test, name)], axis=1) for name, values in train.items()}
    return replace(exact, **whole)  # type: ignore[arg-type]
