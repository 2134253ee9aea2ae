"""What the training data can tell of a linear basis: rank, condition, and what no sample shows."""

from repro.report import writing
from repro.report.tables.table import Column, Row, Table
from repro.results.metric_names import metric_named, written
from repro.results.results import Results
from repro.results.run_setting import Setting
from repro.results.schema import as_text
from repro.results.selectors import settings

EXPERIMENT = "dip_identifiability"
SHOWN = ("basis", "sequence", "grid")
METRICS = ("rank", "condition_raw", "condition_scaled")


def identifiability_table(results: Results) -> Table:
    """Make one row a basis and kind of data; of runs that differ in noise or solver alone, the first."""
    distinct: dict[tuple[str, ...], Setting] = {}
    for setting in settings(results, EXPERIMENT):
        # The last phase is what is examined: after D_H comes D, which has a row of its own.
        if setting.values("rank").size and setting.card["sequence"] != "pretrain":
            distinct.setdefault(tuple(as_text(setting.card[column]) for column in SHOWN), setting)
    columns = (
        *(Column(title) for title in (*SHOWN, "terms")),
        *(Column(metric_named(metric).label) for metric in METRICS),
        Column("not seen"),
    )
    caption = (
        "Rank and condition number of the regression, before and after scaling its columns to unit norm (medians over "
        "members), and the combinations of terms that no sample shows, of T unless V is named. An anchor is the known "
        "energy of one state; grid: how the initial angles of D_H are chosen."
    )
    rows = tuple(_row(results, setting) for setting in distinct.values())
    return Table("identifiability", "Identifiability of the double pendulum", caption, columns, rows)


def _row(results: Results, setting: Setting) -> Row:
    directions = _directions(results, setting)
    unseen = [text for text in directions if text]
    medians = {metric: setting.estimate(metric).median for metric in METRICS}
    card = {column: as_text(setting.card[column]) for column in SHOWN}
    return Row(
        cells=(
            *(written(column, value) for column, value in card.items()),
            str(len(directions)),
            *(writing.number(value) for value in medians.values()),
            "; ".join(unseen) or "nothing",
        ),
        data={**card, "terms": len(directions), **medians, "not_seen": "; ".join(unseen)},
        runs=setting.run_ids,
        commands=(setting.command,) if setting.command else (),
    )


def _directions(results: Results, setting: Setting) -> list[str]:
    """The first member's directions in the order of their singular values: words where they are not seen, else ""."""
    seed, (run, _) = next(iter(setting.members.items()))
    rows = results.identifiability
    rows = rows[(rows["run"] == run) & (rows["member"] == seed)]
    return [str(text) for text in rows.sort_values("order")["direction"]]
