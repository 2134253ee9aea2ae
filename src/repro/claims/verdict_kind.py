"""The words that a claim can be answered with."""

from enum import StrEnum


class VerdictKind(StrEnum):
    """What came of a claim, in the order in which the report counts them."""

    MATCHED = "matched"
    BETTER = "better"
    WORSE = "worse"
    INCONCLUSIVE = "inconclusive"
    NOT_REPRODUCED = "not reproduced"
    NOT_COMPARABLE = "not comparable"
    UNDER_SPECIFIED = "under-specified"
    NOT_RUN = "not run"
