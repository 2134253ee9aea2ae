"""Pretraining on D_H against D alone: the same number of epochs, seed by seed."""

from collections.abc import Iterator

import numpy as np

from repro.report import writing
from repro.report.tables.table import Column, Row, Table
from repro.results.metric_names import metric_named, written
from repro.results.results import Results
from repro.results.run_setting import Setting
from repro.results.schema import CARD, as_text
from repro.results.selectors import paired_values, settings
from repro.results.statistics import paired_ratio

EXPERIMENT = "dip_pretraining"
METRICS = ("mae_tau", "mae_L_raw", "mae_H_centred")
APART = ("sequence", "grid", "pretraining_epochs", "epochs", "literal")  # what a pair may differ in
SHOWN = ("optimiser", "regime", "pretraining_epochs", "epochs")


def pretraining_pairs(results: Results) -> Iterator[tuple[Setting, Setting]]:
    """Pair D_H, then D with D alone: the same setting otherwise, and as many epochs in all."""
    alone = settings(results, EXPERIMENT, {"sequence": "main"})
    counted = [s for s in settings(results, EXPERIMENT, {"sequence": "pretrain"}) if s.card["pretraining_epochs"]]
    for pretrained in counted:
        shared = [column for column in CARD if column not in APART]
        for other in alone:
            alike = all(as_text(pretrained.card[c]) == as_text(other.card[c]) for c in shared)
            if alike and _budget(pretrained) == _budget(other):
                yield pretrained, other


def pretraining_table(results: Results) -> Table:
    """Make one row a pair of settings."""
    columns = (
        *(Column(title.replace("_", " ")) for title in SHOWN),
        *(
            Column(f"{metric_named(m).label}, pretrained / not", f"{metric_named(m).latex}, pretrained / not")
            for m in METRICS
        ),
        *(Column(f"wins, {metric_named(m).label}", f"wins, {metric_named(m).latex}") for m in METRICS),
        Column("pairs"),
    )
    caption = (
        "Ratio seed by seed (same data, initialisation and number of epochs in all): below 1 pretraining on D_H helps. "
        "Median, 95 % t interval on the log scale; wins: in how many pairs the pretrained member has the smaller error."
    )
    rows = tuple(_row(*pair) for pair in pretraining_pairs(results))
    return Table("pretraining_paired", "Pretrained on D_H / on D alone, seed by seed", caption, columns, rows)


def _row(pretrained: Setting, alone: Setting) -> Row:
    pairs = {metric: paired_values(pretrained, alone, metric) for metric in METRICS}
    ratios = {metric: paired_ratio(*values) for metric, values in pairs.items()}
    # A failed member counts as infinitely wrong, so it never wins.
    wins = {m: int(np.sum(np.nan_to_num(a, nan=np.inf) < np.nan_to_num(b, nan=np.inf))) for m, (a, b) in pairs.items()}
    card = {column: as_text(pretrained.card[column]) for column in SHOWN}
    data: dict[str, object] = dict(card)
    for metric, ratio in ratios.items():
        data |= {f"{metric}_ratio": ratio.median, f"{metric}_low": ratio.low, f"{metric}_high": ratio.high}
        data |= {f"{metric}_wins": wins[metric]}
    n = ratios["mae_tau"].n
    return Row(
        cells=(
            *(written(column, value) for column, value in card.items()),
            *(writing.interval(ratio) for ratio in ratios.values()),
            *(f"{won} of {n}" for won in wins.values()),
            str(n),
        ),
        data={**data, "n": n},
        runs=pretrained.run_ids + alone.run_ids,
        commands=tuple(command for command in (pretrained.command, alone.command) if command),
    )


def _budget(setting: Setting) -> int:
    return (setting.card["epochs"] or 0) + (setting.card["pretraining_epochs"] or 0)
