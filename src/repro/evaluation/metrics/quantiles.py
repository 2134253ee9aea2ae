"""How large the rare errors are: quantiles of the absolute error over samples and components."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from repro.evaluation.metric_options import MetricOptions
from repro.plugins.options import Share

if TYPE_CHECKING:
    from repro.data.dataset import Dataset
    from repro.evaluation.pointwise import MetricValues
    from repro.mechanics.system import System
    from repro.models.model import Model


@dataclass(frozen=True)
class Options(MetricOptions):
    """Options of metric=quantiles; shares: of the samples whose error is smaller."""

    shares: tuple[Share, ...] = (0.9, 0.99)

    def measure(
        self, model: Model, parameters: np.ndarray, part: Dataset, system: System | None, split: str
    ) -> Iterator[MetricValues]:
        """quantile_tau[share] in N, N m and quantile_qdd[share] in m/s^2, rad/s^2, where the model predicts them."""
        from repro.evaluation.pointwise import ACCELERATION, FORCE, MetricValues
        from repro.evaluation.predictions import predict

        predicted = predict(model, parameters, part.q, part.qd, part.qdd, part.tau)
        for name, ours, measured, unit in (
            ("tau", predicted.tau, part.tau, FORCE), ("qdd", predicted.acceleration, part.qdd, ACCELERATION)
        ):  # fmt: skip
            if ours is not None:
                for share in self.shares:
                    values = np.quantile(np.abs(ours - measured), share, axis=(1, 2))
                    yield MetricValues(split, f"quantile_{name}[{share:g}]", values, unit)
