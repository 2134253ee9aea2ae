"""No metric beside the usual ones."""

from dataclasses import dataclass

from repro.evaluation.metric_options import MetricOptions


@dataclass(frozen=True)
class Options(MetricOptions):
    """metric=none has no options."""
