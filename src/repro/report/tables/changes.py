"""The table of what was changed in the claims after their first results, from the rows themselves."""

from collections.abc import Sequence

from repro.claims.claims import Claim
from repro.report.tables.table import Row, Table

CAPTION = (
    "Every row of the claims that was changed after results for it were known, with the commit and the reason; an "
    "unchanged row has none. The criteria as a whole were written with results of pilot runs known."
)


def change_table(claims: Sequence[Claim]) -> Table:
    """Make one row per change, in the order of the claims."""
    rows = [
        Row((claim.name, one.commit, one.change, one.reason), {"id": claim.name, **one.model_dump()})
        for claim in claims
        for one in claim.history
    ]
    return Table("changes", "Changes of the claims", CAPTION, ("claim", "commit", "change", "reason"), tuple(rows))
