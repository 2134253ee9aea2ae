"""The table of sensitivities: each assumption, what was put in its place, and what that did to a verdict."""

from collections.abc import Sequence

from repro.claims.assumption_effects import AssumptionEffect
from repro.claims.assumptions import Assumption
from repro.claims.verdicts import Verdict
from repro.report import writing
from repro.report.tables.table import Row, Table
from repro.report.tables.verdicts import measured

CAPTION = (
    "One assumption changed at a time, at scale quick with three members (one to four closed loops for control): too "
    "few to decide anything. Shown is which way the point estimate leans; moved: it leans another way. The baseline "
    "of this scale can lean another way than the verdict of full length."
)
COLUMNS = ("ours", "ci_low", "ci_high", "n", "failed", "leaning")  # of either verdict, in the CSV
SHOWN = ("assumption", "choice", "alternative", "claim", "metric", "ours", "instead_ours", "leaning", "moved")
MOVED = {True: "moved", False: "no", None: writing.ABSENT}


def sensitivity_table(ledger: Sequence[Assumption], compared: Sequence[AssumptionEffect]) -> Table:
    """Make the table, in the order of the assumptions; one that nothing can be run for says why."""
    rows = []
    for row in ledger:
        own = [comparison for comparison in compared if comparison.assumption == row.id]
        rows += [_compared(comparison) for comparison in own] or [_untried(row)]
    columns = ("assumption", "ours", "instead", "claim", "measured", "by ours", "instead [95 %]", "leaning", "moved")
    return Table("sensitivity", "Sensitivities", CAPTION, columns, tuple(rows))


def change(comparison: AssumptionEffect) -> str:
    """Write which way the estimate leans, or how that moves: consistent → outside."""
    before, after = comparison.ours.leaning, comparison.other.leaning
    return before if before == after else f"{before} → {after}"


def _compared(comparison: AssumptionEffect) -> Row:
    ours, other = comparison.ours, comparison.other
    values = {
        "assumption": comparison.assumption,
        "choice": comparison.choice,
        "alternative": comparison.alternative,
        "claim": ours.claim.name,
        "metric": ours.quantity,
        "unit": ours.unit,
        "printed": ours.claim.printed,
        **_data("", ours),
        **_data("instead_", other),
        "moved": MOVED[comparison.moved],
        "note": "",
    }
    texts = {"choice": comparison.choice or writing.ABSENT, "metric": measured(ours), "leaning": change(comparison)}
    texts |= {"ours": writing.interval(ours.estimate), "instead_ours": writing.interval(other.estimate)}
    return Row.of([*ours.rows, *other.rows], values, texts, SHOWN)


def _data(prefix: str, verdict: Verdict) -> dict[str, object]:
    one = verdict.estimate
    values = (one.median, one.low, one.high, one.n, one.failed, verdict.leaning)
    return {f"{prefix}{name}": value for name, value in zip(COLUMNS, values, strict=True)}


def _untried(row: Assumption) -> Row:
    values = {"assumption": row.id, "moved": writing.ABSENT, "note": row.untried}
    return Row.of([], values, {"alternative": row.untried}, SHOWN)
