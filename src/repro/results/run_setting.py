"""One setting is a run card; its members are those of all runs that differ in seeds alone."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from repro.results.columns import Settings
from repro.results.metric_names import metric_named, written
from repro.results.run_card import options
from repro.results.statistics import Estimate, estimate, share
from repro.results.table_schema import Row, as_text


class Measured(NamedTuple):
    """One metric of one run: its unit, and seed -> value."""

    unit: str
    values: dict[int, float]


Metrics = Mapping[tuple[str, str], Measured]  # of one run: (metric, split) -> values


class FromRuns:
    """What is made from rows of the runs table, or of the bench table."""

    rows: Sequence[Row]

    @property
    def runs(self) -> tuple[str, ...]:
        """The ids of the runs."""
        return tuple(dict.fromkeys(row["run"] for row in self.rows))

    @property
    def commands(self) -> tuple[str, ...]:
        """The commands that repeat them."""
        return tuple(dict.fromkeys(row["command"] for row in self.rows if row["command"]))

    @property
    def stale(self) -> bool:
        """Whether the code has changed since one of them."""
        return any(row.get("stale") is True for row in self.rows)

    @property
    def as_printed(self) -> bool:
        """Whether every one follows a protocol as the paper prints it."""
        return bool(self.rows) and all(row.get("as_printed") is True for row in self.rows)


@dataclass(frozen=True)
class RunSetting(FromRuns):
    """One setting with its pooled members: one that diverged counts, a run that failed (no memory, time) does not."""

    card: Row  # the card columns
    rows: tuple[Row, ...]  # its finished rows of the runs table
    measured: Mapping[str, Metrics] = field(default_factory=dict, repr=False)  # run -> its metrics

    @cached_property
    def members(self) -> Mapping[int, tuple[str, str]]:
        """Each member once, by its seed: the run that it is taken from and its status there."""
        found: dict[int, tuple[str, str]] = {}
        for run in sorted(self.rows, key=lambda run: run["run"]):
            name, statuses = run["run"], run["member_status"]
            seeds = run["seeds"] or sorted({seed for of in self.measured.get(name, {}).values() for seed in of.values})
            for place, seed in enumerate(seeds):
                found.setdefault(int(seed), (name, statuses[place] if place < len(statuses) else "ok"))
        return dict(sorted(found.items()))

    @property
    def n(self) -> int:
        """Number of members."""
        return len(self.members)

    @property
    def failed(self) -> int:
        """Number of members that diverged."""
        return sum(status != "ok" for _, status in self.members.values())

    @cached_property
    def settings(self) -> Settings:
        """Every setting that had a part in it, by dotted key."""
        return dict(json.loads(self.rows[0]["config"] or "{}"))

    @cached_property
    def options(self) -> Settings:
        """The settings without a column of their own that differ from the defaults of the options chosen."""
        return options(self.settings, self.rows[0]["changed"].split())

    def text(self, name: str) -> str:
        """The text of a card column, or of a setting by its dotted key."""
        return as_text(self.card[name] if name in self.card else self.settings.get(name))

    def title(self, *columns: str) -> str:
        """Name the setting by some card columns, as people write them."""
        texts = [written(column, self.text(column)) for column in columns]
        return ", ".join(text for text in texts if text)

    def values(self, metric: str) -> np.ndarray:
        """Return the members' values, (member,) by seed; nan for a failed one, empty where none was measured."""
        if metric == "diverged":
            return np.array([float(status != "ok") for _, status in self.members.values()])
        place = (metric.partition("@")[0], metric_named(metric).split)
        columns = {run: metrics[place].values for run, metrics in self.measured.items() if place in metrics}
        if not columns:
            return np.full(self.n if self.failed == self.n else 0, np.nan)
        found = [(columns.get(run, {}).get(seed), status) for seed, (run, status) in self.members.items()]
        return np.array([np.nan if value is None or status != "ok" else value for value, status in found])

    def estimate(self, metric: str) -> Estimate:
        """Summarise one metric over the members, by the metric's own scale."""
        kind, values = metric_named(metric), self.values(metric)
        if kind.scale == "share":
            return share(np.nan_to_num(values, nan=float(kind.lower_is_better)) > 0.5)
        return estimate(values, failed_is=np.inf if kind.lower_is_better else -np.inf)

    def unit(self, metric: str) -> str:
        """Return the unit that was stored with a metric."""
        name = metric.partition("@")[0]
        found = (of.unit for metrics in self.measured.values() for (own, _), of in metrics.items() if own == name)
        return next(found, "")
