"""Tables of models: one row a setting, and the trivial, degenerate and oracle rows of every test set beside them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from repro.report.tables.table import Column, Row, Table
from repro.report.writing import ABSENT, interval
from repro.results.metric_names import metric_named, written
from repro.results.results import Results
from repro.results.run_setting import Setting
from repro.results.schema import as_text
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
)

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


def anchor_title(name: str, basis: str = "") -> str:
    """Name an anchor row; the closed form with the basis that it is in."""
    return f"oracle (least squares on {written('basis', basis)})" if name == ORACLE and basis else ANCHOR_TITLES[name]


READING = (
    "Median over members with the 95 % Student-t interval of those that finished; failed members count as infinitely "
    "wrong in the median. Skill is 1 - error / error of the trivial model. "
    "Forces in N and N m, accelerations in m/s² and rad/s², energies in J."
)


@dataclass(frozen=True)
class Comparison:
    """One table of models: the experiment it shows and the metrics beside the core ones."""

    name: str
    experiment: str
    title: str
    extra: tuple[str, ...] = ()


COMPARISONS = (
    Comparison("bases", "sip_basis", "Bases: raw, engineered, T1 and T2"),
    Comparison("forward_inverse", "sip_forward_inverse", "Forward against inverse objective on identical nets"),
    Comparison(
        "regimes",
        "sip_regimes",
        "Data regimes, labels and noise",
        ("onestep_euler_qd[0]", "onestep_euler_qd[1]", "rollout_qd[0]", "rollout_qd[1]"),
    ),
    Comparison("optimisers", "sip_optimisers", "Optimisers and architectures", ("fit_seconds",)),
    Comparison("energies", "sip_energies", "Energies", ("mae_H_sum", "min_T", "momentum_transform")),
    Comparison(
        "dip_identifiability",
        "dip_identifiability",
        "The double pendulum in closed form: what D and D_H tell",
        ("mae_H_sum", "mae_H_sum@free", "coefficient_error", "rank"),
    ),
    Comparison(
        "dip_pretraining",
        "dip_pretraining",
        "The double pendulum: pretraining on D_H",
        ("mae_H_sum@free", "mae_tau@free", "mae_H_sum", "coefficient_error", "fit_seconds"),
    ),
    Comparison("dip_neural", "dip_neural", "The double pendulum: networks", ("gravity", "fit_seconds")),
    Comparison("selection", "sip_selection", "Basis selection", ("support_exact", "false_terms", "coefficient_error")),
    Comparison(
        "ph_passivity",
        "ph_passivity",
        "Port-Hamiltonian models: passivity, and the energy of long free motion",
        (
            *("passivity_margin_worst", "passivity_margin_plant", "gains_energy", "damping_error"),
            *("energy_error_2s", "energy_error_10s", "energy_error_40s", "energy_error_100s", "energy_error_worst"),
        ),
    ),
    Comparison(
        "ph_damping",
        "ph_damping",
        "Friction beside the energies",
        ("damping_error", "damping_error[0]", "damping_error[1]", "damping_error[2]", "min_eig_C"),
    ),
    Comparison("composition", "composition", "A double pendulum of trained sub-models, and from scratch"),
    Comparison(
        "chains",
        "chains",
        "Chains of a link that was learned once, and chains learned as a whole",
        (
            *(f"chain_error_{links}" for links in (2, 10, 30, 100, 1000, 10000)),
            *(f"whole_chain_error_{links}" for links in (2, 10, 30, 100)),
            *("chain_seconds_1000", "chain_seconds_10000"),
        ),
    ),
)


def model_tables(results: Results) -> list[Table]:
    """Make the table of every comparison that has been run; an experiment without one of its own has a plain one."""
    tables = [model_table(results, comparison) for comparison in (*COMPARISONS, *_plain(results))]
    return [table for table in tables if table.rows]


def _plain(results: Results) -> list[Comparison]:
    """The experiments on models that no comparison names, in alphabetical order."""
    named = {comparison.experiment for comparison in COMPARISONS} | set(results.control["experiment"])
    others = sorted(set(results.runs["experiment"]) - named - {""})
    return [Comparison(name, name, f"Experiment {name}") for name in others]


def model_table(results: Results, comparison: Comparison) -> Table:
    """Make one comparison's table; without runs it has no rows."""
    found = [s for s in settings(results, comparison.experiment) if anchor_name(s) not in (TRIVIAL, DEGENERATE)]
    layout = _Layout(
        card=[column for column in varying_columns(found) if column not in ("literal", "model")],
        metrics=[m for m in (*comparison.extra, *CORE) if any(setting.values(m).size for setting in found)],
    )
    rows: list[Row] = []
    for test_set in _test_sets(found):
        anchors = {name: anchor(results, comparison.experiment, name, test_set) for name in ANCHORS}
        oracle = anchors[ORACLE]
        for setting in found:
            if test_set_of(setting.card) == test_set and not (oracle and setting.runs == oracle.runs):
                rows.append(layout.row(setting))
        for name, reference in anchors.items():
            if reference is None:
                rows.append(layout.absent_row(f"{ANCHOR_TITLES[name]}: not run", test_set))
            else:
                rows.append(layout.row(reference, anchor_as=name))
    return Table(comparison.name, comparison.title, READING, layout.columns, tuple(rows))


@dataclass(frozen=True)
class _Layout:
    """Which card columns and metrics a table shows."""

    card: Sequence[str]
    metrics: Sequence[str]

    @property
    def columns(self) -> tuple[Column, ...]:
        named = [metric_named(metric) for metric in self.metrics]
        return (
            Column("model"),
            *(Column(column.replace("_", " ")) for column in self.card),
            *(Column(metric.label, metric.latex) for metric in named),
            *(Column(title) for title in ("members", "failed", "stale")),
        )

    def row(self, setting: Setting, *, anchor_as: str = "") -> Row:
        # Of an anchor only what places it is said: it has no optimiser or width to compare.
        shown = test_set_of(setting.card) if anchor_as else self.card
        card = {column: as_text(setting.card[column]) if column in shown else "" for column in self.card}
        title = anchor_title(anchor_as, setting.card["basis"]) if anchor_as else setting.title("model")
        found = {metric: setting.estimate(metric) for metric in self.metrics}
        data: dict[str, Any] = {"model": title, **card}
        for metric, one in found.items():
            data |= {metric: one.median, f"{metric}_low": one.low, f"{metric}_high": one.high}
        data |= {"n": setting.n, "failed": setting.failed, "stale": setting.stale}
        return Row(
            cells=(
                title,
                *(written(column, value) for column, value in card.items()),
                *(interval(one) if metric != "trapped" else counted(setting) for metric, one in found.items()),
                *(str(setting.n), str(setting.failed), "stale" if setting.stale else ""),
            ),
            data=data,
            runs=setting.run_ids,
            commands=(setting.command,) if setting.command else (),
            anchor=bool(anchor_as),
        )

    def absent_row(self, title: str, test_set: Mapping[str, Any]) -> Row:
        card = {column: as_text(test_set.get(column)) for column in self.card}
        absent = [ABSENT] * len(self.metrics)
        return Row((title, *card.values(), *absent, "0", "0", ""), {"model": title, **card, "n": 0}, anchor=True)


def counted(setting: Setting) -> str:
    """Of how many members the flag holds; a failed member is no better than a trapped one."""
    values = setting.values("trapped")
    if not values.size:
        return ABSENT
    trapped = int(np.sum(np.nan_to_num(values, nan=1.0) > 0.5))
    return f"{trapped} of {setting.n}" + (" ⚠" if trapped else "")


def _test_sets(found: Sequence[Setting]) -> list[dict[str, Any]]:
    distinct: list[dict[str, Any]] = []
    for setting in found:
        if test_set_of(setting.card) not in distinct:
            distinct.append(test_set_of(setting.card))
    return distinct
