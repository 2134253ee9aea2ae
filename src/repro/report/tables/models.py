"""Tables of models: one row per setting, and the trivial, degenerate and oracle rows of every test set beside them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from pydantic.dataclasses import dataclass as checked

from repro.report.tables.table import Row, Table
from repro.report.tables.under_trained import training_of
from repro.report.writing import ABSENT, interval
from repro.results.metric_names import metric_named, written
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import (
    ANCHORS,
    DEGENERATE,
    ORACLE,
    TRIVIAL,
    anchor,
    anchor_name,
    settings,
    test_set_of,
    varying_columns,
    with_varying_options,
)
from repro.results.table_schema import as_text

# Never one error alone: force, acceleration (mean and median), energy, Lagrangian (raw, relative, canonical), inertia.
CORE = (
    *("mae_tau", "mae_qdd", "median_ae_qdd", "mae_H_legendre", "mae_H_centred"),
    *("mae_L_raw", "mae_L_relative", "mae_L_canonical", "min_eig_M", "trapped", "skill_tau", "skill_qdd"),
)
ANCHOR_TITLES = {
    TRIVIAL: "trivial (τ = 0)",
    DEGENERATE: "degenerate (L = pₓ²/2m)",
    ORACLE: "oracle (least squares)",
}
CAPTION = (
    "Median over members with its 95 % interval between two order statistics; failed members count as infinitely wrong "
    "in both. Skill is 1 - error / error of the trivial model. "
    "Forces in N and N m, accelerations in m/s² and rad/s², energies in J."
)


@checked(frozen=True)
class ModelTable:
    """A table of the models of one experiment: `metrics` come before the core ones."""

    kind: Literal["models"]
    name: str
    experiment: str
    title: str
    metrics: tuple[str, ...] = ()

    def make(self, results: Results) -> Table:
        """Make the table; without runs it has no rows."""
        shown = [s for s in settings(results, self.experiment) if anchor_name(s) not in (TRIVIAL, DEGENERATE)]
        shown = with_varying_options(shown)
        training = {setting.run_ids: training_of(setting, shown) for setting in shown}
        layout = _Layout(
            card=[column for column in varying_columns(shown) if column not in ("as_printed", "model")],
            metrics=[m for m in (*self.metrics, *CORE) if any(setting.values(m).size for setting in shown)],
            training=training if set(training.values()) != {ABSENT} else {},
        )
        rows: list[Row] = []
        distinct: list[dict[str, Any]] = []
        for test_set in (test_set_of(setting.card) for setting in shown):
            if test_set not in distinct:
                distinct.append(test_set)
        for test_set in distinct:
            anchors = {name: anchor(results, self.experiment, name, test_set) for name in ANCHORS}
            oracle = anchors[ORACLE]
            for setting in shown:
                if test_set_of(setting.card) == test_set and not (oracle and setting.runs == oracle.runs):
                    rows.append(layout.row(setting))
            rows += [layout.anchor_row(name, found, test_set) for name, found in anchors.items()]
        return Table(self.name, self.title, CAPTION, layout.columns, tuple(rows))


def plain_tables(results: Results, named: set[str]) -> list[Table]:
    """Make a table of every experiment on models that is not named elsewhere, in alphabetical order."""
    others = sorted(set(results.runs["experiment"]) - set(results.control["experiment"]) - named - {""})
    return [ModelTable("models", name, name, f"Experiment {name}").make(results) for name in others]


def anchor_title(name: str, basis: str = "") -> str:
    """Name an anchor row; the closed form with the basis that it is in."""
    return f"oracle (least squares on {written('basis', basis)})" if name == ORACLE and basis else ANCHOR_TITLES[name]


def model_title(setting: RunSetting, *columns: str) -> str:
    """Name a setting by its basis, where it is a Lagrangian on one, else by its model, and by further card columns."""
    return setting.title("basis" if setting.card["model"] == "lagrangian" else "model", *columns)


def counted(setting: RunSetting) -> str:
    """Count the members that are trapped; a failed member counts as one."""
    values = setting.values("trapped")
    if not values.size:
        return ABSENT
    trapped = int(np.sum(np.nan_to_num(values, nan=1.0) > 0.5))
    return f"{trapped} of {setting.n}" + (" ⚠" if trapped else "")


@dataclass(frozen=True)
class _Layout:
    """Which card columns and metrics a table shows, and the marks of training, where there are any, by run ids."""

    card: Sequence[str]
    metrics: Sequence[str]
    training: Mapping[tuple[str, ...], str]

    @property
    def columns(self) -> tuple[str, ...]:
        card = (column.replace("_", " ") for column in self.card)
        metrics = (metric_named(metric).label for metric in self.metrics)
        return ("model", *card, *metrics, *(["trained"] if self.training else []), "members", "failed", "stale")

    def row(self, setting: RunSetting, *, anchor_as: str = "") -> Row:
        # An anchor shows only its test set: it has no optimiser or width to compare.
        shown = test_set_of(setting.card) if anchor_as else self.card
        card = {column: as_text(setting.card[column]) if column in shown else "" for column in self.card}
        title = anchor_title(anchor_as, setting.card["basis"]) if anchor_as else setting.title("model")
        estimates = {metric: setting.estimate(metric) for metric in self.metrics}
        data: dict[str, Any] = {"model": title, **card}
        for metric, one in estimates.items():
            data |= {metric: one.median, f"{metric}_low": one.low, f"{metric}_high": one.high}
        trained = {"trained": self.training.get(setting.run_ids, ABSENT)} if self.training else {}
        data |= {**trained, "n": setting.n, "failed": setting.failed, "stale": setting.stale}
        cells = (
            title,
            *(written(column, value) for column, value in card.items()),
            *(interval(one) if metric != "trapped" else counted(setting) for metric, one in estimates.items()),
            *trained.values(),
            *(str(setting.n), str(setting.failed), "stale" if setting.stale else ""),
        )
        return Row.of([setting], cells, data, anchor=bool(anchor_as))

    def anchor_row(self, name: str, found: RunSetting | None, test_set: Mapping[str, Any]) -> Row:
        if found is not None:
            return self.row(found, anchor_as=name)
        title = f"{ANCHOR_TITLES[name]}: not run"
        card = {column: as_text(test_set.get(column)) for column in self.card}
        absent = [ABSENT] * (len(self.metrics) + bool(self.training))
        return Row((title, *card.values(), *absent, "0", "0", ""), {"model": title, **card, "n": 0}, anchor=True)
