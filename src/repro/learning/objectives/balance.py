"""The balance of momentum over windows: what is fitted where accelerations are not measured.

Over a window, p(end) - p(start) - the integral of dL/dq - friction is the impulse of the recorded force, whatever the
acceleration is. On the cubic Hermite path through the samples this is the integral of tau_hat itself, because p is the
integral of its rate: so the rows are those of the inverse equation, integrated by Gauss' rule within each interval and
divided by the length of the window (N, N m). The force is held from sample to sample, and exact in the integral.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.polynomial.legendre import leggauss

from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.learning.objective import Objective
from repro.learning.objectives import inverse
from repro.learning.training_problem import TrainingTask
from repro.models.model import Model
from repro.plugins.options import Positive

NODES = 3  # within an interval: exact up to the fifth order, where the path itself is of the third


@dataclass(frozen=True)
class Options(inverse.Options):
    """Options of objective=balance; window: s over which momentum is balanced."""

    needs_accelerations: ClassVar[bool] = False

    window: Positive = 0.2

    def task(self, model: Model, dataset: Dataset, minimised: Objective) -> TrainingTask:
        """The rows of the inverse equation, integrated over each window."""
        return balance_task(model, dataset, minimised, self.window, self.error_scale)


def balance_task(
    model: Model, dataset: Dataset, objective: Objective, window: float, error_scale: float | None = None
) -> TrainingTask:
    """The balance over successive windows of `window` s within the episodes of a dataset, at least one interval each.

    error_scale: s in m/s^2 and rad/s^2 together; each window weighs 1 / (1 + |mean qdd|^2 / s^2). UserError where no
    episode is as long as a window.
    """
    intervals = max(1, round(window / float(np.median(np.diff(dataset.time)))))
    first = starts_of_windows(dataset.episode, intervals)
    if not len(first):
        raise UserError(f"objective.window = {window}: no episode is longer; shorten it to less than an episode")
    sample = first[:, None] + np.arange(intervals)
    step = (dataset.time[sample + 1] - dataset.time[sample])[..., None]
    places, weights = leggauss(NODES)
    path = _hermite(dataset.q, dataset.qd, sample, step[..., None], (places + 1) / 2)
    tau = np.broadcast_to(dataset.tau[:, sample, None], path[0].shape)
    measured = {
        name: np.ascontiguousarray(values.reshape(*values.shape[:2], -1, values.shape[-1]))
        for name, values in zip(("q", "qd", "qdd", "tau"), (*path, tau), strict=True)
    }
    duration = step.sum(1, keepdims=True)
    share = np.broadcast_to((step * (weights / 2) / duration).reshape(1, len(first), -1), measured["q"].shape[:3])
    weight = None
    if error_scale is not None:
        last = first + intervals
        mean = (dataset.qd[:, last] - dataset.qd[:, first]) / duration[..., 0]
        weight = 1 / (1 + (mean**2).sum(-1) / error_scale**2)
    return TrainingTask(model, objective, measured, weight, share=share.copy())


def starts_of_windows(episode: np.ndarray, intervals: int) -> np.ndarray:
    """The first sample (window,) of each window."""
    edges = np.flatnonzero(np.diff(episode)) + 1
    parts = zip(np.append(0, edges), np.append(edges, len(episode)), strict=True)
    return np.concatenate([np.arange(start, stop - intervals, intervals) for start, stop in parts])


def _hermite(
    q: np.ndarray, qd: np.ndarray, sample: np.ndarray, step: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, qd, qdd (member, window, interval, node, n_q) of the cubic that has both ends' q and qd (member, sample, n_q).

    sample: (window, interval) the start of each; step: (window, interval, 1, 1) its length in s; places: (node,) of it.
    """
    start, end, v0, v1 = (
        each[:, :, :, None] for each in (q[:, sample], q[:, sample + 1], qd[:, sample], qd[:, sample + 1])
    )
    s = places[:, None]
    a, b = v0 * step - (end - start), (end - start) - v1 * step
    inner = s * (1 - s)
    position = (1 - s) * start + s * end + inner * ((1 - s) * a + s * b)
    slope = (end - start) + (1 - 2 * s) * ((1 - s) * a + s * b) + inner * (b - a)
    bend = -2 * ((1 - s) * a + s * b) + 2 * (1 - 2 * s) * (b - a)
    return position, slope / step, bend / step**2
