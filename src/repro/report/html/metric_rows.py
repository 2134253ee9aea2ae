"""The metrics of one run, one row per metric: the median and every member."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

from repro.results.metric_names import metric_named

if TYPE_CHECKING:
    import pandas as pd

SPLITS = {"test": "on the test set", "free": "on the test part of D_H", "train": "of the training"}


@dataclass(frozen=True)
class MetricRow:
    """One metric: `values` holds one per member, in the order of seeds, nan where it has none."""

    split: str
    name: str
    label: str
    meaning: str
    unit: str
    median: float
    values: tuple[float, ...]


def metric_rows(table: "pd.DataFrame | None", members: Mapping[int, str]) -> Sequence[MetricRow]:
    """Return the metrics of one run in their stored order, test set first; `members` are its seeds."""
    if table is None:
        return ()
    units: dict[tuple[str, str], str] = {}
    values: dict[tuple[str, str], dict[int, float]] = {}
    columns = table[["split", "metric", "unit", "member", "value"]]
    for split, metric, unit, member, value in columns.itertuples(index=False):
        units[split, metric] = unit
        values.setdefault((split, metric), {})[int(member)] = float(value)
    rows = [_row(split, name, units[split, name], of, members) for (split, name), of in values.items()]
    order = list(SPLITS)
    return sorted(rows, key=lambda row: order.index(row.split))


def _row(split: str, name: str, unit: str, of: Mapping[int, float], members: Mapping[int, str]) -> MetricRow:
    kind = metric_named(name)
    values = tuple(of.get(seed, math.nan) for seed in members)
    finite = [value for value in values if not math.isnan(value)]
    middle = median(finite) if finite else math.nan
    return MetricRow(split, name, kind.label, kind.meaning, "" if unit == "1" else unit, middle, values)
