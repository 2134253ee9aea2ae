"""One setting is a run card; its members are those of all runs that differ in seeds alone."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from repro.results.columns import Settings
from repro.results.metric_names import metric_named, written
from repro.results.run_card import options
from repro.results.statistics import Estimate, estimate, share
from repro.results.table_schema import as_text

Measured = dict[tuple[str, str], dict[tuple[str, int], float]]


@dataclass(frozen=True)
class RunSetting:
    """One setting with its pooled members; a member that diverged counts, a run that failed (no memory, time) does not.

    card      the card columns
    runs      its finished rows of the runs table
    measured  (metric, split) -> (run, seed) -> value
    units     metric -> unit
    """

    card: Mapping[str, Any]
    runs: tuple[Mapping[str, Any], ...]
    measured: Measured = field(default_factory=dict, repr=False)
    units: Mapping[str, str] = field(default_factory=dict, repr=False)

    @cached_property
    def members(self) -> Mapping[int, tuple[str, str]]:
        """Each member once, by its seed: the run that it is taken from and its status there."""
        found: dict[int, tuple[str, str]] = {}
        for run in sorted(self.runs, key=lambda run: run["run"]):
            name, statuses = run["run"], run["member_status"]
            seeds = run["seeds"] or sorted({seed for of in self.measured.values() for own, seed in of if own == name})
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

    @property
    def run_ids(self) -> tuple[str, ...]:
        """The runs behind this setting."""
        return tuple(run["run"] for run in self.runs)

    @property
    def command(self) -> str:
        """The commands that repeat it, one per run."""
        return " && ".join(run["command"] for run in self.runs if run["command"])

    @property
    def stale(self) -> bool:
        """Whether the code has changed since one of the runs."""
        return any(run["stale"] is True for run in self.runs)

    @property
    def as_printed(self) -> bool:
        """Whether the paper's own protocol was followed to its end."""
        return self.card.get("as_printed") is True

    @cached_property
    def settings(self) -> Settings:
        """Every setting that had a part in it, by dotted key."""
        return dict(json.loads(self.runs[0]["config"] or "{}"))

    @cached_property
    def options(self) -> Settings:
        """The settings without a column of their own that differ from the defaults of the options chosen."""
        return options(self.settings, self.runs[0]["changed"].split())

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
        column = self.measured.get((metric.partition("@")[0], metric_named(metric).split))
        if column is None:
            return np.full(self.n if self.failed == self.n else 0, np.nan)
        found = [(column.get((run, seed)), status) for seed, (run, status) in self.members.items()]
        return np.array([np.nan if value is None or status != "ok" else value for value, status in found])

    def estimate(self, metric: str) -> Estimate:
        """Summarise one metric over the members, by the metric's own scale."""
        kind, values = metric_named(metric), self.values(metric)
        if kind.scale == "share":
            return share(np.nan_to_num(values, nan=float(kind.lower_is_better)) > 0.5)
        return estimate(values, failed_is=np.inf if kind.lower_is_better else -np.inf)

    def unit(self, metric: str) -> str:
        """Return the unit that was stored with a metric."""
        return self.units.get(metric.partition("@")[0], "")
