"""The run card: the settings of a run, which of them are not the usual ones, and what was counted while it ran."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

from repro.results.columns import LOOP, RUN, Column, Settings
from repro.results.table_schema import Cell, as_column, as_text

OPTIONS = "options"
MEASURED = ("n_train", "epochs")


@dataclass(frozen=True)
class RunCard:
    """What a run was."""

    settings: Settings  # every setting that had a part in it, by dotted key, at the scale of the run
    changed: frozenset[str]  # keys of those that were not the defaults of the options chosen when it was run
    measured: Mapping[str, object]  # n_train and epochs, as counted in the run
    seeds: tuple[int, ...] = ()  # one per member, with the status in which the fit left it
    member_status: tuple[str, ...] = ()

    @classmethod
    def of(cls, summary: Mapping[str, Any]) -> Self:
        """Read the card from the summary in a run.json; empty where there is none. Raises TypeError or ValueError."""
        if not summary.get("settings"):
            return cls({}, frozenset(), {})
        counted = summary.get("card") or {}
        return cls(
            dict(summary["settings"]),
            frozenset(summary["changed"]),
            {name: counted.get(name) for name in MEASURED},
            tuple(int(seed) for seed in counted.get("seeds") or ()),
            tuple(str(status) for status in counted.get("member_status") or ()),
        )

    def run_columns(self) -> dict[str, Cell]:
        """The columns of `runs` and `metrics` that say what was run."""
        counted = {name: as_column(RUN[name].kind, value) for name, value in self.measured.items()}
        return self._values(RUN) | counted

    def loop_columns(self) -> dict[str, Cell]:
        """The columns of `control` that say which model was driven by which controller, in which task."""
        return self._values(LOOP)

    def _values(self, columns: Mapping[str, Column]) -> dict[str, Cell]:
        if not self.settings:
            return {name: as_column(column.kind, None) for name, column in columns.items()}
        values = {name: as_column(column.kind, column.value(self.settings)) for name, column in columns.items()}
        own = options(self.settings, self.changed, {**RUN, **columns})
        return values | {OPTIONS: ", ".join(spelled(own, self.settings))}


def options(settings: Settings, changed: Iterable[str], columns: Mapping[str, Column] = RUN) -> Settings:
    """The changed settings that no column shows, by dotted key, in alphabetical order."""
    shown = {key for column in columns.values() for key in column.keys}
    return {key: settings[key] for key in sorted(changed) if key not in shown}


def spelled(chosen: Settings, settings: Settings) -> list[str]:
    """Spell options as `key=value`, by the last part of the key where no other setting of the run ends with it."""
    ends = Counter(map(_end, settings))
    return [f"{_end(key) if ends[_end(key)] == 1 else key}={as_text(chosen[key]) or 'null'}" for key in chosen]


def _end(key: str) -> str:
    return key.rpartition(".")[2]
