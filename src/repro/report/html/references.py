"""Which claims and tables stand on which run."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from repro.claims.verdicts import Verdict
from repro.report.content import Content
from repro.report.tables.table import Table


@dataclass
class References:
    """What one run answers: claims by name, tables by name and title."""

    claims: list[str] = field(default_factory=list)
    tables: dict[str, str] = field(default_factory=dict)


def references(content: Content) -> Mapping[str, References]:
    """Return, for each run that anything refers to, what refers to it."""
    by_run: dict[str, References] = {}
    _collect_claims(content.verdicts, by_run)
    _collect_tables(content.tables[1:], by_run)
    return by_run


def _collect_claims(verdicts: Iterable[Verdict], by_run: dict[str, References]) -> None:
    for verdict in verdicts:
        for run in verdict.runs:
            by_run.setdefault(run, References()).claims.append(verdict.claim.name)


def _collect_tables(tables: Iterable[Table], by_run: dict[str, References]) -> None:
    for table in tables:
        for run in {run for row in table.rows for run in row.runs if run}:
            by_run.setdefault(run, References()).tables[table.name] = table.title
