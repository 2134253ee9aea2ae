"""What sensors record of a simulated motion, and the estimates of the motion that are made from it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from repro.data.data_options import RandomForce
from repro.data.dataset import Dataset, Measurement
from repro.data.differentiation import difference, savitzky_golay
from repro.data.smooth import smooth
from repro.mechanics.inputs import generalised_force, input_matrix
from repro.mechanics.system import System

Streams = Sequence[Mapping[str, np.random.Generator]]


def recorded(options: RandomForce, exact: Dataset, streams: Streams, system: System) -> Dataset:
    """The data with a recorded training part: what is measured, with which errors, and how the rest is made.

    streams: one of each purpose per member.
    """
    train, labels, noise = exact.train, options.labels, options.noise

    def noisy(name: str, values: np.ndarray) -> np.ndarray:
        draws = [stream[name].standard_normal(values.shape[1:]) for stream in streams] if noise[name] else ()
        return np.asarray(values + noise[name] * np.stack(draws)) if draws else values

    tau = noisy("tau", train.tau)
    if noise["force"]:
        still = np.zeros((*train.tau.shape[:2], len(system.inputs)))
        tau = tau + generalised_force(system, train.q, noisy("force", still))
    q, qd = _encoded(options, noisy("q", train.q), train), noisy("qd", train.qd)
    if options.measured == "accelerations" and labels in ("exact", "differenced"):
        qdd = difference(qd, train.time, train.episode) if labels == "differenced" else train.qdd
        return _with_train(exact, q=q, qd=qd, qdd=noisy("qdd", qdd), tau=tau)
    leverage = np.sqrt((input_matrix(system, train.q) ** 2).sum(-1).reshape(-1, train.n_q).mean(0))
    rounding = _steps(options, train) ** 2 / 12  # which is uniform over a step
    position_noise = np.sqrt(np.full(train.n_q, noise["q"]) ** 2 + rounding)
    force_noise = np.hypot(noise["tau"], noise["force"] * leverage)
    record = Measurement(q, q_noise=position_noise, tau_noise=force_noise)
    if options.measured != "positions":
        record = replace(record, qd=qd, qd_noise=np.full(train.n_q, noise["qd"]))
    whole = _with_train(exact, q=record.q, qd=qd)
    whole_record = replace(record, q=whole.q, qd=None if record.qd is None else whole.qd)
    q, qd, qdd, _ = estimated(record, train.time, train.episode, labels)
    return replace(_with_train(exact, q=q, qd=qd, qdd=qdd, tau=tau), measurement=whole_record)


def _encoded(options: RandomForce, q: np.ndarray, train: Dataset) -> np.ndarray:
    """Positions as encoders show them, turns counted again where they were lost."""
    angles = np.array([coordinate.is_angle for coordinate in train.coordinates])
    if options.encoder_zero:
        q = q + options.encoder_zero * angles
    if options.quantisation:
        step = _steps(options, train)
        q = np.where(step > 0, np.round(q / np.where(step > 0, step, 1)) * step, q)
    if options.wrapped:
        turned = np.where(angles, np.pi - np.mod(np.pi - q, 2 * np.pi), q)
        q = unwrapped(turned, train.angles, train.episode)
    return q


def _steps(options: RandomForce, train: Dataset) -> np.ndarray:
    """Of the encoders (n_q,)."""
    steps = options.quantisation or (0.0, 0.0)
    return np.array([steps[coordinate.is_angle] for coordinate in train.coordinates])


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
