"""Every table of the report, in the order in which it is read."""

from repro.claims.verdicts import Verdict
from repro.report.paper import Paper
from repro.report.tables.changes import change_table
from repro.report.tables.failures import failures_table
from repro.report.tables.models import plain_tables
from repro.report.tables.table import Table
from repro.report.tables.timing import timing_table
from repro.report.tables.verdicts import verdict_table
from repro.results.results import Results


def all_tables(results: Results, verdicts: list[Verdict], paper: Paper) -> list[Table]:
    """Make every table that has rows: the verdicts, those of the paper, experiments that it does not name, the rest."""
    named = {query.experiment for query in paper.tables}
    others = [
        *(query.make(results) for query in paper.tables),
        *plain_tables(results, named),
        *(timing_table(results), failures_table(results), change_table([verdict.claim for verdict in verdicts])),
    ]
    return [verdict_table(verdicts), *(table for table in others if table.rows)]
