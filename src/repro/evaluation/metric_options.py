"""What every metric of conf/metric declares: its options, and the numbers that it takes of a fitted ensemble."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from repro.plugins.options import PluginOptions

if TYPE_CHECKING:
    import numpy as np

    from repro.data.dataset import Dataset
    from repro.evaluation.pointwise import MetricValues
    from repro.mechanics.system import System
    from repro.models.model import Model

METRICS = "evaluation.metrics"  # the folder of these choices


@dataclass(frozen=True)
class MetricOptions(PluginOptions):
    """Options of a metric; a file of evaluation/metrics extends it and its `measure`."""

    def measure(
        self, model: Model, parameters: np.ndarray, part: Dataset, system: System | None, split: str
    ) -> Iterator[MetricValues]:
        """Named numbers, one value per member each; nothing unless the metric says more.

        parameters: (member, n_parameters); part: the samples, arrays (member, sample, n_q); system: the true system,
        where it is known; split: what the samples are, such as "test".
        """
        yield from ()
