"""What came of the claims as wholes: a claim is no better than the weakest of its parts."""

from collections import Counter
from collections.abc import Mapping, Sequence

from repro.claims.verdict_kind import VerdictClass
from repro.claims.verdicts import Verdict

# From the weakest: a claim of several parts is counted under the first of these that one of them has.
WEAKEST_FIRST = (
    VerdictClass.NOT_SUPPORTED,
    VerdictClass.NOT_RUN,
    VerdictClass.UNDECIDED,
    VerdictClass.WITH_CHANGES,
    VerdictClass.SUPPORTED,
    VerdictClass.BY_CONSTRUCTION,
)


def classes_of_claims(verdicts: Sequence[Verdict]) -> Mapping[str, VerdictClass]:
    """Return claim -> the class under which it is counted, in the order of the claims."""
    found: dict[str, set[VerdictClass]] = {}
    for verdict in verdicts:
        found.setdefault(verdict.claim.id, set()).add(verdict.counted_as)
    return {id: next(kind for kind in WEAKEST_FIRST if kind in kinds) for id, kinds in found.items()}


def counts_of_claims(verdicts: Sequence[Verdict]) -> Mapping[VerdictClass, int]:
    """Return class -> the number of claims in it, for the classes that occur, in the order of the front page."""
    counted = Counter(classes_of_claims(verdicts).values())
    return {kind: counted[kind] for kind in VerdictClass if counted[kind]}


def headline(verdicts: Sequence[Verdict]) -> str:
    """Write the counts of claims in one line: 24 claims: 8 supported, 3 undecided."""
    counts = counts_of_claims(verdicts)
    return f"{sum(counts.values())} claims: " + ", ".join(f"{number} {kind}" for kind, number in counts.items())
