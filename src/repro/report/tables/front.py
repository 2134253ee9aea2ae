"""The README's tables of models: what the same data give, from doing nothing to the closed form."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from repro.report import writing
from repro.report.tables.models import anchor_title, counted
from repro.results.metric_names import metric_named
from repro.results.results import Results
from repro.results.run_setting import Setting
from repro.results.schema import as_text
from repro.results.selectors import anchor_name, settings


@dataclass(frozen=True)
class FrontTable:
    """The settings of one experiment that a selector means, by medians of some metrics; `named_by` card columns."""

    experiment: str
    where: Mapping[str, Any]
    named_by: tuple[str, ...]
    metrics: tuple[str, ...]


FRONT_TABLES = {
    "models": FrontTable(
        "sip_regimes",
        {"regime": "episodes", "episode_steps": 1000, "labels": "exact", "tau_noise": 0.0},
        ("hidden", "optimiser"),
        ("mae_tau", "mae_qdd", "mae_H_centred", "mae_L_canonical", "fit_seconds"),
    ),
    "trap": FrontTable(
        "dip_neural",
        {"system": "dip", "n_train": [1000, None], "tau_noise": 0.0, "sequence": "main"},
        ("hidden", "options", "optimiser"),
        ("trapped", "mae_tau", "mae_qdd", "mae_H_centred", "min_eig_M", "fit_seconds"),
    ),
}


def front_block(results: Results, table: FrontTable) -> str:
    """Return one line a model, worst first: medians of its errors over the members, and seconds a member."""
    found = sorted(
        settings(results, table.experiment, table.where), key=lambda setting: -setting.estimate("mae_tau").median
    )
    titles = ["model", *(metric_named(metric).label for metric in table.metrics), "members"]
    lines = [f"| {' | '.join(titles)} |", f"|{' --- |' * len(titles)}"]
    for setting in found:
        cells = (_title(setting, table), *(_cell(setting, metric) for metric in table.metrics), str(setting.n))
        lines.append(f"| {' | '.join(writing.markdown(cell) for cell in cells)} |")
    return "\n".join(lines)


def _cell(setting: Setting, metric: str) -> str:
    return counted(setting) if metric == "trapped" else writing.number(setting.estimate(metric).median)


def _title(setting: Setting, table: FrontTable) -> str:
    name = anchor_name(setting)
    if name is not None:
        return anchor_title(name, setting.card["basis"])
    first = "basis" if setting.card["model"] == "lagrangian" else "model"
    title = setting.title(first, *table.named_by)
    return f"{title}, {as_text(setting.card['epochs'])} epochs" if setting.card["optimiser"] == "adam" else title
