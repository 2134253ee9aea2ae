"""The table of runs that failed or are missing."""

from repro.report import writing
from repro.report.tables.table import Row, Table
from repro.results.results import Results

CAPTION = "Runs that an experiment lists and that failed or are missing; no number above counts them as done."


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
    columns = ("experiment", "run", "outcome", "error")
    return Table("failures", "Failed and missing runs", CAPTION, columns, rows)
