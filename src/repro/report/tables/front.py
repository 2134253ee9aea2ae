"""The README's tables of models: what the same data give, from doing nothing to the closed form."""

from collections.abc import Mapping
from typing import Any

from pydantic.dataclasses import dataclass as checked

from repro.report.tables.models import anchor_title, counted, model_title
from repro.report.tables.table import markdown_table
from repro.report.writing import number
from repro.results.metric_names import metric_named
from repro.results.results import Results
from repro.results.run_setting import RunSetting
from repro.results.selectors import anchor_name, settings, with_varying_options
from repro.results.table_schema import as_text


@checked(frozen=True)
class FrontTable:
    """The settings of one experiment that a selector means, by medians of some metrics; `named_by` card columns."""

    name: str
    experiment: str
    where: Mapping[str, Any]
    named_by: tuple[str, ...]
    metrics: tuple[str, ...]


def front_block(results: Results, table: FrontTable) -> str:
    """Return one line a model, worst first: medians of its metrics over the members."""
    shown = with_varying_options(settings(results, table.experiment, table.where))
    rows = [
        [
            _title(setting, table),
            *(counted(setting) if m == "trapped" else number(setting.estimate(m).median) for m in table.metrics),
            str(setting.n),
        ]
        for setting in sorted(shown, key=lambda setting: -setting.estimate("mae_tau").median)
    ]
    return markdown_table(["model", *(metric_named(metric).label for metric in table.metrics), "members"], rows)


def _title(setting: RunSetting, table: FrontTable) -> str:
    name = anchor_name(setting)
    if name is not None:
        return anchor_title(name, setting.card["basis"])
    title = model_title(setting, *table.named_by)
    return f"{title}, {as_text(setting.card['epochs'])} epochs" if setting.card["optimiser"] == "adam" else title
