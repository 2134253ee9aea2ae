"""Tables of models: one row per setting, and the trivial, degenerate and oracle rows of every test set beside them.

A fit with a budget of CPU time is marked by whether it had come to its end; the README shows the medians of a few.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from pydantic.dataclasses import dataclass as checked

from repro.report.tables.table import Row, Table, markdown_table
from repro.report.writing import ABSENT, number
from repro.results.columns import Settings
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
BUDGET = "optimiser.budget_s"
STILL_FALLS = 0.9  # to less than this share of the error after at most half of the budget
TRAINED, UNDER_TRAINED = "to its end", "under-trained"
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
        columns = [column for column in varying_columns(shown) if column not in ("as_printed", "model")]
        metrics = [m for m in (*self.metrics, *CORE) if any(setting.values(m).size for setting in shown)]
        training = {setting.runs: training_of(setting, shown) for setting in shown}
        training = training if set(training.values()) != {ABSENT} else {}
        titles = {"model": "model", **{column: column.replace("_", " ") for column in columns}}
        titles |= {metric: metric_named(metric).label for metric in metrics}
        titles |= {"trained": "trained"} if training else {}
        titles |= {"n": "members", "failed": "failed", "stale": "stale"}
        rows: list[Row] = []
        test_sets = [test_set_of(setting.card) for setting in shown]
        for test_set in {as_text([*each.values()]): each for each in test_sets}.values():
            anchors = {name: anchor(results, self.experiment, name, test_set) for name in ANCHORS}
            oracle = anchors[ORACLE]
            for setting in shown:
                if test_set_of(setting.card) == test_set and not (oracle and setting.runs == oracle.runs):
                    rows.append(_row(setting, columns, columns, metrics, training))
            for name, found in anchors.items():
                if found is not None:
                    # An anchor shows only its test set: it has no optimiser or width to compare.
                    rows.append(_row(found, columns, test_set, metrics, training, anchor_as=name))
                    continue
                card = {column: as_text(test_set.get(column)) for column in columns}
                values = {"model": f"{ANCHOR_TITLES[name]}: not run", **card, "n": 0}
                rows.append(Row.of([], values, {"failed": "0", "stale": ""}, [*titles], anchor=True))
        return Table(self.name, self.title, CAPTION, tuple(titles.values()), tuple(rows))


@checked(frozen=True)
class FrontTable:
    """The settings of one experiment that a selector means, by medians of some metrics; `named_by` card columns."""

    name: str
    experiment: str
    where: Mapping[str, Any]
    named_by: tuple[str, ...]
    metrics: tuple[str, ...]


def plain_tables(results: Results, named: set[str]) -> list[Table]:
    """Make a table of every experiment on models that is not named elsewhere, in alphabetical order."""
    others = sorted(set(results.runs["experiment"]) - set(results.control["experiment"]) - named - {""})
    return [ModelTable("models", name, name, f"Experiment {name}").make(results) for name in others]


def front_block(results: Results, table: FrontTable) -> str:
    """Return one line per model, worst first: medians of its metrics over the members."""
    shown = with_varying_options(settings(results, table.experiment, table.where))
    rows = [
        [
            _front_title(setting, table),
            *(counted(setting) if m == "trapped" else number(setting.estimate(m).median) for m in table.metrics),
            str(setting.n),
        ]
        for setting in sorted(shown, key=lambda setting: -setting.estimate("mae_tau").median)
    ]
    return markdown_table(["model", *(metric_named(metric).label for metric in table.metrics), "members"], rows)


def _front_title(setting: RunSetting, table: FrontTable) -> str:
    name = anchor_name(setting)
    if name is not None:
        return anchor_title(name, setting.card["basis"])
    title = model_title(setting, *table.named_by)
    return f"{title}, {as_text(setting.card['epochs'])} epochs" if setting.card["optimiser"] == "adam" else title


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


def _row(
    setting: RunSetting,
    columns: Sequence[str],
    shown: Collection[str],
    metrics: Sequence[str],
    training: Mapping[tuple[str, ...], str],
    *,
    anchor_as: str = "",
) -> Row:
    """One setting: its values in the `shown` columns, and the mark of training, where there are any, by run ids."""
    card = {column: as_text(setting.card[column]) if column in shown else "" for column in columns}
    title = anchor_title(anchor_as, setting.card["basis"]) if anchor_as else setting.title("model")
    estimates = {metric: setting.estimate(metric) for metric in metrics}
    trained = {"trained": training.get(setting.runs, ABSENT)} if training else {}
    values = {"model": title, **card, **estimates, **trained, "n": setting.n, "failed": setting.failed}
    texts = {column: written(column, value) for column, value in card.items()}
    texts |= {"trapped": counted(setting), "stale": "stale" if setting.stale else ""}
    return Row.of(setting.rows, {**values, "stale": setting.stale}, texts, anchor=bool(anchor_as))


def training_of(setting: RunSetting, others: Sequence[RunSetting]) -> str:
    """Compare a setting with the one of the longest shorter budget, at most half of its own, that is equal otherwise.

    The median MAE of accelerations decides. A setting without a budget, such another, or a finite error has no mark.
    """
    own, after = _budget(setting), setting.estimate("mae_qdd").median
    shorter = {
        _budget(each): each for each in others if 2 * _budget(each) <= own < math.inf and _rest(each) == _rest(setting)
    }
    if not shorter or not math.isfinite(after):
        return ABSENT
    before = shorter[max(shorter)].estimate("mae_qdd").median
    return UNDER_TRAINED if after < STILL_FALLS * before else TRAINED


def _budget(setting: RunSetting) -> float:
    budget = setting.settings.get(BUDGET)
    return float(budget) if isinstance(budget, int | float) else math.inf


def _rest(setting: RunSetting) -> Settings:
    return {key: value for key, value in setting.settings.items() if key != BUDGET}
