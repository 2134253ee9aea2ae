"""What the training data can show of a linear basis: rank, condition, and the directions that no sample shows."""

from collections.abc import Mapping
from typing import Any, Literal

from pydantic.dataclasses import dataclass as checked

from repro.report.tables.table import Row, Table
from repro.results.metric_names import metric_named, written
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import settings
from repro.results.table_schema import as_text

METRICS = ("rank", "condition_raw", "condition_scaled")


@checked(frozen=True)
class IdentifiabilityTable:
    """One row per kind of data, named by card `columns`; settings that agree with `leave_out` are not shown."""

    kind: Literal["identifiability"]
    name: str
    experiment: str
    title: str
    caption: str
    columns: tuple[str, ...]
    leave_out: Mapping[str, Any]

    def make(self, results: Results) -> Table:
        """Make the table; of settings that differ in other columns alone, the first stands for all."""
        hidden = [setting.runs for setting in settings(results, self.experiment, self.leave_out)]
        distinct: dict[tuple[str, ...], RunSetting] = {}
        for setting in settings(results, self.experiment):
            if setting.values("rank").size and setting.runs not in hidden:
                distinct.setdefault(tuple(as_text(setting.card[column]) for column in self.columns), setting)
        titles = (*self.columns, "terms", *(metric_named(metric).label for metric in METRICS), "not seen")
        rows = tuple(self._row(results, setting) for setting in distinct.values())
        return Table(self.name, self.title, self.caption, titles, rows)

    def _row(self, results: Results, setting: RunSetting) -> Row:
        # The first member's directions in the order of their singular values: in words where not seen, else "".
        seed, (run, _) = next(iter(setting.members.items()))
        found = results.identifiability
        found = found[(found["run"] == run) & (found["member"] == seed)].sort_values("order")
        directions = [str(text) for text in found["direction"]]
        unseen = [text for text in directions if text]
        medians = {metric: setting.estimate(metric).median for metric in METRICS}
        card = {column: as_text(setting.card[column]) for column in self.columns}
        texts = {column: written(column, value) for column, value in card.items()}
        texts["not_seen"] = "; ".join(unseen) or "nothing"
        values = {**card, "terms": len(directions), **medians, "not_seen": "; ".join(unseen)}
        return Row.of(setting.rows, values, texts)
