"""Every table of the report in reading order, and those that any paper has: timings, failures, changes."""

import math
from collections.abc import Sequence

from repro.claims.claims import Claim
from repro.claims.verdicts import Verdict
from repro.report import writing
from repro.report.paper import Paper
from repro.report.tables.cost import cost_table
from repro.report.tables.models import plain_tables
from repro.report.tables.table import Row, Table
from repro.report.tables.verdicts import verdict_table
from repro.results.results import Results
from repro.results.table_schema import as_text, records


def all_tables(results: Results, verdicts: list[Verdict], paper: Paper) -> list[Table]:
    """Make every table that has rows: the verdicts, those of the paper, experiments that it does not name, the rest."""
    named = {query.experiment for query in paper.tables}
    others = [
        *(query.make(results) for query in paper.tables),
        *plain_tables(results, named),
        timing_table(results),
        failures_table(results),
        change_table([verdict.claim for verdict in verdicts]),
        cost_table(results),
    ]
    return [verdict_table(verdicts), *(table for table in others if table.rows)]


def timing_table(results: Results) -> Table:
    """Make the table of paired timings."""
    caption = (
        "Paired and interleaved timings on one machine: a ratio above 1 says that ours is faster. Where an error is "
        "named, the time is that of training until it falls to that share of the error of a model without motion or "
        "energy."
    )
    columns = (
        *("comparison", "ours", "other", "size", "members", "until", "reached by ours, other"),
        *("other / ours (quartiles)", "ours [ms]", "other [ms]", "threads", "protocol"),
    )
    rows = []
    for bench in records(results.bench):
        number = {key: writing.number(value) for key, value in bench.items() if isinstance(value, float | None)}
        quartiles = f"[{number['ratio_q25']}, {number['ratio_q75']}]"
        reached = f"{bench['ours_reached']}, {bench['other_reached']} of {bench['starts']}"
        cells = (
            *(as_text(bench[key]) for key in ("name", "ours", "other", "size", "members")),
            *((f"{bench['metric']} {as_text(bench['goal'])}".strip(), reached) if bench["metric"] else ("", "")),
            f"{number['ratio_median']} {quartiles}",
            *("not reached" if bench[key] == math.inf else number[key] for key in ("ours_ms", "other_ms")),
            *(as_text(bench[key]) for key in ("threads", "protocol")),
        )
        data = {key: value for key, value in bench.items() if key not in ("run", "command")}
        rows.append(Row(cells, data, (bench["run"],), tuple(filter(None, (bench["command"],)))))
    return Table("timing", "Timing", caption, columns, tuple(rows))


def failures_table(results: Results) -> Table:
    """Make the table of what was started and is not there: runs that failed or are missing."""
    caption = "Runs that an experiment lists and that failed or are missing; no number above counts them as done."
    columns = ("experiment", "run", "outcome", "error")
    rows = tuple(
        Row.of([run], {key: run[key] for key in columns}, {key: run[key] or writing.ABSENT for key in columns})
        for run in results.rows
        if run["outcome"] != "ok"
    )
    return Table("failures", "Failed and missing runs", caption, columns, rows)


def change_table(claims: Sequence[Claim]) -> Table:
    """Make the table of what was changed in the claims after their first results, from the rows themselves."""
    caption = (
        "Every row of the claims that was changed after results for it were known, with the commit and the reason; an "
        "unchanged row has none. The criteria as a whole were written with results of pilot runs known."
    )
    rows = [Row.of([], {"id": claim.name, **one.model_dump()}) for claim in claims for one in claim.history]
    return Table("changes", "Changes of the claims", caption, ("claim", "commit", "change", "reason"), tuple(rows))
