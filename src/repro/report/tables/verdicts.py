"""The table of verdicts: what the paper says, what we find, and how the two stand to each other."""

from collections.abc import Sequence

from repro.claims.verdict_kind import VerdictKind
from repro.claims.verdicts import Verdict
from repro.report import writing
from repro.report.tables.table import Row, Table
from repro.results.metric_names import metric_named

READING = (
    "Numbers: a printed value is one draw of an unknown seed; consistent when it lies within the 95 % prediction "
    "interval of our members, else outside. Statements: decided only where the whole 95 % interval lies on one side of "
    "the criterion (ratios by a margin of 5 %), else undecided; too few below 5 members, starts or problem sizes. "
    "Verdicts are not corrected for their number: of every 20 decided intervals one may miss. Other protocol: the runs "
    "are not of a protocol as printed. Preview: a smaller scale. Stale: the code has changed since the run."
)

# In the table: what `in_words` writes, and its title.
SHOWN = {
    "claim": "claim",
    "about": "what the paper says",
    "marked": "verdict",
    "printed": "printed",
    "ours": "ours [95 %]",
    "measured": "measured",
    "members": "units",
    "section": "where",
    "cure": "smallest change that makes it hold",
}


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """Make the table of claims: printed, ours, verdict. Its CSV is claims.csv."""
    columns = (*SHOWN.values(), "remarks")
    return Table("verdicts", "Verdicts", READING, columns, tuple(_verdict_row(verdict) for verdict in verdicts))


def mark(verdict: Verdict) -> str:
    """Write a verdict with which way it leans, and its marks: too few, leans supported (preview)."""
    words, marked = str(verdict.verdict), marks(verdict)
    if verdict.verdict in (VerdictKind.UNDECIDED, VerdictKind.TOO_FEW):
        words += f", leans {verdict.leaning}"
    return f"{words} ({', '.join(marked)})" if marked else words


def marks(verdict: Verdict) -> list[str]:
    """What has to be said of the runs behind a verdict."""
    other = bool(verdict.runs) and not verdict.as_printed and not verdict.preview
    return ["preview"] * verdict.preview + ["other protocol"] * other + ["stale"] * verdict.stale


def cure(verdict: Verdict) -> str:
    """Write the smallest change that makes a claim hold, with what it gives; empty where none is named."""
    if verdict.claim.cure is None:
        return ""
    change, found = verdict.claim.cure.change, verdict.cure
    if found is None:
        return change
    given = f"{writing.interval(found.estimate)}, " if found.estimate.n else ""
    return f"{change}: {given}{found.verdict}"


def measured(verdict: Verdict) -> str:
    """Write what was measured, with its unit: MAE τ, in N, N m."""
    label = metric_named(verdict.quantity).label
    return f"{label}, in {verdict.unit}" if verdict.unit not in ("", "1") else label


def in_words(verdict: Verdict) -> dict[str, str]:
    """Write all that is shown of a verdict, by name."""
    claim, estimate = verdict.claim, verdict.estimate
    return {
        "claim": claim.name,
        "about": claim.about,
        "section": claim.section,
        "printed": writing.number(claim.printed),
        "measured": measured(verdict),
        "ours": writing.interval(estimate),
        "interval": writing.interval(estimate).partition(" ")[2],
        **{name: writing.number(getattr(estimate, name)) for name in ("median", "low", "high")},
        "members": str(estimate.n or writing.ABSENT),
        "failed": str(estimate.failed),
        "verdict": verdict.verdict,
        "marked": mark(verdict),
        "marks": "; ".join(filter(None, (*marks(verdict), verdict.flag))),
        "flag": verdict.flag,
        "note": verdict.note,
        "cure": cure(verdict),
    }


def _verdict_row(verdict: Verdict) -> Row:
    claim, estimate, shown = verdict.claim, verdict.estimate, in_words(verdict)
    shown["members"] += f", {estimate.failed} failed" if estimate.failed else ""
    remarks = "; ".join(filter(None, (verdict.flag, verdict.note)))
    return Row(
        cells=(*(shown[name] for name in SHOWN), remarks),
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
            "class": verdict.counted_as,
            "leaning": verdict.leaning,
            "prediction_low": verdict.prediction[0],
            "prediction_high": verdict.prediction[1],
            "failed": estimate.failed,
            "preview": verdict.preview,
            "as_printed": verdict.as_printed,
            "stale": verdict.stale,
            "flag": verdict.flag,
            "cure": shown["cure"],
            "cure_runs": " ".join(verdict.cure.runs if verdict.cure else ()),
            "note": verdict.note,
        },
        runs=verdict.runs,
        commands=verdict.commands,
    )
