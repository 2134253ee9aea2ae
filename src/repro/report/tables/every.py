"""Every table of the report, in the order in which it is read."""

from collections.abc import Sequence

from repro.claims.verdicts import Verdict
from repro.report import writing
from repro.report.tables.closed_loops import control_tables
from repro.report.tables.identifiability import identifiability_table
from repro.report.tables.models import model_tables
from repro.report.tables.pretraining import pretraining_table
from repro.report.tables.table import Column, Row, Table
from repro.report.tables.verdicts import verdict_table
from repro.results.metric_names import written
from repro.results.results import Results
from repro.results.run_setting import Setting
from repro.results.schema import as_text, plain
from repro.results.selectors import NotRunError, like_for_like, paired_values, settings
from repro.results.statistics import paired_ratio


def all_tables(results: Results, verdicts: Sequence[Verdict]) -> list[Table]:
    """Make every table that has something to say; the verdicts first."""
    others = [
        *(paired_table(results), identifiability_table(results), pretraining_table(results)),
        *control_tables(results),
        *(timing_table(results), failures_table(results)),
    ]
    return [verdict_table(verdicts), *model_tables(results), *(table for table in others if table.rows)]


def paired_table(results: Results) -> Table:
    """Pair forward with inverse fits of the same net, optimiser, budget and seed."""
    rows = []
    for inverse in settings(results, "sip_forward_inverse", {"objective": "inverse"}):
        where = {column: inverse.card[column] for column in ("model", "basis", "hidden", "optimiser", "epochs")}
        try:
            pair = like_for_like(
                results, "sip_forward_inverse", {**where, "objective": "inverse"}, {**where, "objective": "forward"}
            )
        except NotRunError:
            continue
        rows.append(_paired_row(*pair))
    columns = (
        *(Column(title) for title in ("basis", "hidden", "optimiser", "epochs")),
        Column("MAE τ, inverse / forward", r"MAE$_\tau$, inverse / forward"),
        Column("MAE q̈, inverse / forward", r"MAE$_{\ddot q}$, inverse / forward"),
        *(Column(title) for title in ("members", "inverse failed", "forward failed")),
    )
    caption = (
        "Ratio member by member (same data, initialisation and budget): below 1 the inverse objective identifies "
        "better. Median, 95 % t interval on the log scale of the pairs in which both finished."
    )
    return Table("forward_inverse_paired", "Inverse / forward, pair by pair", caption, columns, tuple(rows))


def timing_table(results: Results) -> Table:
    """Make the table of paired timings."""
    columns = (
        *("comparison", "ours", "other", "size", "members", "other / ours (quartiles)"),
        *("ours [ms]", "other [ms]", "threads", "protocol"),
    )
    rows = []
    for bench in results.bench.to_dict("records"):
        text = {str(key): as_text(plain(value)) for key, value in bench.items()}
        quartiles = f"[{writing.number(bench['ratio_q25'])}, {writing.number(bench['ratio_q75'])}]"
        rows.append(
            Row(
                cells=(
                    *(text[key] for key in ("name", "ours", "other", "size", "members")),
                    f"{writing.number(bench['ratio_median'])} {quartiles}",
                    *(writing.number(bench[key]) for key in ("ours_ms", "other_ms")),
                    *(text[key] for key in ("threads", "protocol")),
                ),
                data={str(key): value for key, value in bench.items() if key not in ("run", "command")},
                runs=(text["run"],),
                commands=(text["command"],) if text["command"] else (),
            )
        )
    caption = "Paired and interleaved timings on one machine: a ratio above 1 says that ours is faster."
    return Table("timing", "Timing", caption, tuple(Column(title) for title in columns), tuple(rows))


def failures_table(results: Results) -> Table:
    """Make the table of what was started and is not there: runs that failed or are missing."""
    absent = results.runs[results.runs["outcome"] != "ok"]
    rows = tuple(
        Row(
            cells=(run["experiment"], run["run"] or writing.ABSENT, run["outcome"], run["error"] or writing.ABSENT),
            data={key: run[key] for key in ("experiment", "run", "outcome", "error")},
            runs=(run["run"],),
            commands=(run["command"],) if run["command"] else (),
        )
        for run in absent.to_dict("records")
    )
    caption = "Runs that an experiment lists and that failed or are missing; no number above counts them as done."
    columns = tuple(Column(title) for title in ("experiment", "run", "outcome", "error"))
    return Table("failures", "Failed and missing runs", caption, columns, rows)


def _paired_row(inverse: Setting, forward: Setting) -> Row:
    ratios = {metric: paired_ratio(*paired_values(inverse, forward, metric)) for metric in ("mae_tau", "mae_qdd")}
    card = {column: inverse.card[column] for column in ("basis", "hidden", "optimiser", "epochs")}
    data = dict(card)
    for metric, ratio in ratios.items():
        data |= {f"{metric}_ratio": ratio.median, f"{metric}_low": ratio.low, f"{metric}_high": ratio.high}
    return Row(
        cells=(
            *(written(column, as_text(value)) for column, value in card.items()),
            *(writing.interval(ratio) for ratio in ratios.values()),
            str(ratios["mae_tau"].n),
            str(inverse.failed),
            str(forward.failed),
        ),
        data={**data, "n": ratios["mae_tau"].n, "inverse_failed": inverse.failed, "forward_failed": forward.failed},
        runs=inverse.run_ids + forward.run_ids,
        commands=tuple(command for command in (inverse.command, forward.command) if command),
    )
