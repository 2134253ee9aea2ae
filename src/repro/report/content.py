"""Everything that a report shows, before it takes a form."""

from collections.abc import Sequence
from dataclasses import dataclass

from repro.claims.assumptions import Assumption
from repro.claims.verdicts import Verdict
from repro.report.figures.figure import Figure
from repro.report.paper import Paper
from repro.report.placeholders import Texts
from repro.report.sections import ReportSection
from repro.report.tables.table import Table
from repro.results.results import Results


@dataclass(frozen=True)
class Content:
    """Results with what was made of them; the table of verdicts is the first of the tables, figures are drawn ones."""

    paper: Paper
    results: Results
    verdicts: Sequence[Verdict]
    tables: Sequence[Table]
    figures: Sequence[Figure]
    sections: Sequence[ReportSection]
    assumptions: Sequence[Assumption]
    texts: Texts
