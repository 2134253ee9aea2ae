"""Two ways compared seed by seed, such as one objective against another on the same net and budget."""

from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np
from pydantic.dataclasses import dataclass as checked

from repro.report import writing
from repro.report.tables.table import Row, Table
from repro.results.metric_names import metric_named, written
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import alike, paired_values, settings
from repro.results.statistics import paired_ratio
from repro.results.table_schema import as_text

Where = Mapping[str, Any]


@checked(frozen=True)
class PairedTable:
    """Ratios of `metrics`, seed by seed, of every setting of `ours` to its partner in `other`."""

    kind: Literal["paired"]
    name: str
    experiment: str
    title: str
    caption: str
    ours: Where
    other: Where
    names: tuple[str, str]  # of the two, in titles
    columns: tuple[str, ...]  # card columns that name a row
    metrics: tuple[str, ...]
    count: Literal["failed", "wins"]  # adds the failed members, or the pairs in which ours is better
    apart: tuple[str, ...] = ()  # card columns in which a pair may differ besides those of the selectors
    needs: tuple[str, ...] = ()  # card columns that must have a value

    def make(self, results: Results) -> Table:
        """Make one row per pair of settings."""
        labels = [metric_named(metric).label for metric in self.metrics]
        ours, other = self.names
        ratios = [f"{label}, {ours} / {other}" for label in labels]
        if self.count == "wins":
            counts = [*(f"wins, {label}" for label in labels), "pairs"]
        else:
            counts = ["members", *(f"{name} failed" for name in self.names)]
        titles = (*(column.replace("_", " ") for column in self.columns), *ratios, *counts)
        partners = pairs(results, self.experiment, self.ours, self.other, self.apart, self.needs)
        return Table(self.name, self.title, self.caption, titles, tuple(self._row(*pair) for pair in partners))

    def _row(self, ours: RunSetting, other: RunSetting) -> Row:
        values = {metric: paired_values(ours, other, metric) for metric in self.metrics}
        ratios = {metric: paired_ratio(*pair) for metric, pair in values.items()}
        n = next(iter(ratios.values())).n
        data: dict[str, Any] = {column: as_text(ours.card[column]) for column in self.columns}
        texts = {column: written(column, value) for column, value in data.items()}
        for metric, ratio in ratios.items():
            data |= {f"{metric}_ratio": ratio.median, f"{metric}_low": ratio.low, f"{metric}_high": ratio.high}
            texts[f"{metric}_ratio"] = writing.interval(ratio)
            if self.count == "wins":
                data[f"{metric}_wins"] = _wins(*values[metric])
                texts[f"{metric}_wins"] = f"{data[f'{metric}_wins']} of {n}"
        data["n"] = n
        counts = [f"{metric}_wins" for metric in self.metrics] + ["n"]
        if self.count == "failed":
            data |= {f"{name}_failed": one.failed for name, one in zip(self.names, (ours, other), strict=True)}
            counts = ["n", *(f"{name}_failed" for name in self.names)]
        shown = [*self.columns, *(f"{metric}_ratio" for metric in self.metrics), *counts]
        return Row.of([*ours.rows, *other.rows], data, texts, shown)


def pairs(
    results: Results,
    experiment: str,
    ours: Where,
    other: Where,
    apart: tuple[str, ...] = (),
    needs: tuple[str, ...] = (),
) -> Iterator[tuple[RunSetting, RunSetting]]:
    """Pair every setting of `ours` with those of `other` that are alike otherwise and took as many epochs in all."""
    named = {*ours, *other, *apart}
    others = settings(results, experiment, other)
    for one in settings(results, experiment, ours):
        if not all(one.card[column] for column in needs):
            continue
        for another in others:
            if alike(one, another, named) and epochs_in_all(one) == epochs_in_all(another):
                yield one, another


def epochs_in_all(setting: RunSetting) -> int:
    """Return the epochs of pretraining and training together."""
    return (setting.card["epochs"] or 0) + (setting.card["pretraining_epochs"] or 0)


def _wins(ours: np.ndarray, other: np.ndarray) -> int:
    """Count the pairs in which ours has the smaller error; a failed member is infinitely wrong, so it never wins."""
    return int(np.sum(np.nan_to_num(ours, nan=np.inf) < np.nan_to_num(other, nan=np.inf)))
