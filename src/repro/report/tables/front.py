"""The README's tables of models: what the same data give, from doing nothing to the closed form."""

from collections.abc import Mapping
from typing import Any

from pydantic.dataclasses import dataclass as checked

from repro.report import writing
from repro.report.tables.models import anchor_title, counted, model_title
from repro.report.tables.table import markdown_head, markdown_line
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
    shown = sorted(
        with_varying_options(settings(results, table.experiment, table.where)),
        key=lambda setting: -setting.estimate("mae_tau").median,
    )
    lines = markdown_head(["model", *(metric_named(metric).label for metric in table.metrics), "members"])
    for setting in shown:
        cells = (_title(setting, table), *(_cell(setting, metric) for metric in table.metrics), str(setting.n))
        lines.append(markdown_line([writing.markdown(cell) for cell in cells]))
    return "\n".join(lines)


def _cell(setting: RunSetting, metric: str) -> str:
    return counted(setting) if metric == "trapped" else writing.number(setting.estimate(metric).median)


def _title(setting: RunSetting, table: FrontTable) -> str:
    name = anchor_name(setting)
    if name is not None:
        return anchor_title(name, setting.card["basis"])
    title = model_title(setting, *table.named_by)
    return f"{title}, {as_text(setting.card['epochs'])} epochs" if setting.card["optimiser"] == "adam" else title
