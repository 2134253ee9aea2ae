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

SHOWN = ("claim", "about", "marked", "printed", "ours", "measured", "units", "section", "cure", "remarks")
# Of columns that have another one than the name of what they show.
TITLES = {
    "about": "what the paper says",
    **dict.fromkeys(("marked", "flagged"), "verdict"),
    **dict.fromkeys(("ours", "compared"), "ours [95 %]"),
    "members": "units",
    "section": "where",
    "cure": "smallest change that makes it hold",
}


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """Make the table of claims: printed, ours, verdict. Its CSV is claims.csv."""
    return Table("verdicts", "Verdicts", READING, titles(SHOWN), tuple(_verdict_row(verdict) for verdict in verdicts))


def titles(names: Sequence[str]) -> tuple[str, ...]:
    """The titles of columns that show what `in_words` writes under these names."""
    return tuple(TITLES.get(name, name) for name in names)


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
    claim, estimate, marked = verdict.claim, verdict.estimate, mark(verdict)
    ours = writing.interval(estimate)
    members = str(estimate.n or writing.ABSENT)
    return {
        "claim": claim.name,
        "about": claim.about,
        "section": claim.section,
        "printed": writing.number(claim.printed),
        "measured": measured(verdict),
        "ours": ours,
        "interval": ours.partition(" ")[2],
        "compared": ours + (f" against {writing.interval(verdict.other)}" if verdict.other else ""),
        **{name: writing.number(getattr(estimate, name)) for name in ("median", "low", "high")},
        "members": members,
        "failed": str(estimate.failed),
        "units": members + (f", {estimate.failed} failed" if estimate.failed else ""),
        "verdict": verdict.verdict,
        "marked": marked,
        "flagged": "; ".join(filter(None, (marked, verdict.flag))),
        "marks": "; ".join(filter(None, (*marks(verdict), verdict.flag))),
        "flag": verdict.flag,
        "note": verdict.note,
        "remarks": "; ".join(filter(None, (verdict.flag, verdict.note))),
        "cure": cure(verdict),
    }


def _verdict_row(verdict: Verdict) -> Row:
    claim, estimate, shown = verdict.claim, verdict.estimate, in_words(verdict)
    values = {
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
        **{name: getattr(verdict, name) for name in ("preview", "as_printed", "stale", "flag")},
        "cure": shown["cure"],
        "cure_runs": " ".join(verdict.cure.runs if verdict.cure else ()),
        "note": verdict.note,
    }
    return Row.of(verdict.rows, values, shown, SHOWN)
