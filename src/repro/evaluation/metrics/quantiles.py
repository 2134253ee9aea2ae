"""How large the rare errors are: quantiles of the absolute error over samples and components."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from repro.data.dataset import Dataset
from repro.evaluation.metric_options import MetricOptions
from repro.evaluation.pointwise import ACCELERATION, FORCE, MetricValues
from repro.evaluation.predictions import predict
from repro.mechanics.system import System
from repro.models.model import Model
from repro.plugins.options import Share


@dataclass(frozen=True)
class Options(MetricOptions):
    """Options of metric=quantiles; shares: of the samples whose error is smaller."""

    shares: tuple[Share, ...] = (0.9, 0.99)

    def measure(
        self, model: Model, parameters: np.ndarray, part: Dataset, system: System | None, split: str
    ) -> Iterator[MetricValues]:
        """quantile_tau[share] in N, N m and quantile_qdd[share] in m/s^2, rad/s^2, where the model predicts them."""
        predicted = predict(model, parameters, part.q, part.qd, part.qdd, part.tau)
        for name, ours, measured, unit in (
            ("tau", predicted.tau, part.tau, FORCE), ("qdd", predicted.acceleration, part.qdd, ACCELERATION)
        ):  # fmt: skip
            if ours is not None:
                for share in self.shares:
                    values = np.quantile(np.abs(ours - measured), share, axis=(1, 2))
                    yield MetricValues(split, f"quantile_{name}[{share:g}]", values, unit)
