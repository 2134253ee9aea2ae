"""Signs of a poor fit that need no knowledge of the true system, one line each."""

from collections.abc import Iterator, Sequence

import numpy as np

from repro.data.dataset import Dataset
from repro.evaluation.pointwise import MetricValues


def doubts(metrics: Sequence[MetricValues], data: Dataset) -> Iterator[str]:
    """Lines: no better than the mean of the training part, M not positive definite. metrics: one value per member."""
    of_test = {metric.name: metric.values for metric in metrics if metric.split == "test"}
    for name, quantity in (("tau", "force"), ("qdd", "acceleration")):
        ours = of_test.get(f"mae_{name}")
        if ours is None or np.isnan(ours).all():
            continue
        mean = float(mean_predictor(data, name).mean())
        worse = int(np.sum(~(ours < mean)))
        if worse and mean > 0:
            yield (
                f"the {quantity} is predicted no better than by its mean: mae_{name} {np.median(ours):.3g} against "
                f"{mean:.3g}{_of(worse, ours)}"
            )
    least = of_test.get("min_eig_M")
    if least is not None and (indefinite := int(np.sum(least <= 0))):
        yield f"the mass matrix is not positive definite: least eigenvalue {least.min():.3g}{_of(indefinite, least)}"


def mean_predictor(data: Dataset, name: str) -> np.ndarray:
    """Mean absolute error on the test part of the mean of the training part of tau or qdd, one value per member."""
    constant = getattr(data.train, name).mean(axis=1, keepdims=True)
    return np.asarray(np.abs(getattr(data.test, name) - constant).mean((1, 2)))


def mean_predictor_errors(data: Dataset) -> Iterator[MetricValues]:
    """The errors of the mean predictor as metrics, to stand beside those of a model."""
    for name in ("tau", "qdd"):
        yield MetricValues("test", f"mean_mae_{name}", mean_predictor(data, name), "")


def _of(count: int, values: np.ndarray) -> str:
    return "" if len(values) == 1 else f" ({count} of {len(values)} members)"
