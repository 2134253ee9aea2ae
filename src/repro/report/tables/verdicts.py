"""The table of verdicts: what the paper says, what we find, and how the two stand to each other."""

from collections.abc import Sequence

from repro.claims.verdicts import Verdict
from repro.report import writing
from repro.report.tables.table import Row, Table
from repro.results.metric_names import metric_named
from repro.results.statistics import Estimate

READING = (
    "Numbers: matched when our median lies within the claim's tolerance, better or worse when the whole 95 % interval "
    "lies on that side of the printed value, else inconclusive. Statements: a predicate on stored runs. Preview: not "
    "yet the paper's protocol at full length. Stale: the code has changed since the run."
)


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """Make the table of claims: printed, ours, verdict. Its CSV is claims.csv."""
    columns = (
        *("claim", "what the paper says", "verdict", "printed", "ours [95 %]", "measured", "members", "where"),
        "remarks",
    )
    return Table(
        "verdicts",
        "Verdicts",
        READING,
        columns,
        tuple(_verdict_row(verdict) for verdict in verdicts),
    )


def mark(verdict: Verdict) -> str:
    """Write a verdict with its marks: matched (preview)."""
    marks = ["preview"] * verdict.preview + ["stale"] * verdict.stale
    return f"{verdict.verdict} ({', '.join(marks)})" if marks else verdict.verdict


def measured(verdict: Verdict) -> str:
    """Write what was measured, with its unit: MAE τ, in N, N m."""
    label = metric_named(verdict.quantity).label
    return f"{label}, in {verdict.unit}" if verdict.unit not in ("", "1") else label


def _members(estimate: Estimate) -> str:
    failed = f", {estimate.failed} failed" if estimate.failed else ""
    return f"{estimate.n or writing.ABSENT}{failed}"


def _verdict_row(verdict: Verdict) -> Row:
    claim, estimate = verdict.claim, verdict.estimate
    remarks = "; ".join(part for part in (verdict.flag, verdict.note) if part)
    printed = writing.number(claim.printed)
    if claim.tolerance is not None:
        printed += f" [{claim.tolerance}]"
    return Row(
        cells=(
            claim.name,
            claim.about,
            mark(verdict),
            printed,
            writing.interval(estimate),
            measured(verdict),
            _members(estimate),
            claim.section,
            remarks,
        ),
        data={
            "id": claim.name,
            "metric": verdict.quantity,
            "unit": verdict.unit,
            "printed": claim.printed,
            "ours": estimate.median,
            "ci_low": estimate.low,
            "ci_high": estimate.high,
            "n": estimate.n,
            "verdict": verdict.verdict,
            "failed": estimate.failed,
            "preview": verdict.preview,
            "stale": verdict.stale,
            "flag": verdict.flag,
            "note": verdict.note,
        },
        runs=verdict.runs,
        commands=verdict.commands,
    )
