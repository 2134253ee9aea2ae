"""The words that a claim can be answered with, and the classes under which they are counted."""

from collections.abc import Mapping
from enum import StrEnum


class VerdictKind(StrEnum):
    """What came of a claim."""

    CONSISTENT = "consistent"
    SUPPORTED = "supported"
    WITH_CHANGES = "supported with changes"
    BY_CONSTRUCTION = "true by construction"
    UNDECIDED = "undecided"
    TOO_FEW = "too few"
    UNDER_SPECIFIED = "under-specified"
    NOT_COMPARABLE = "not comparable"
    UNINFORMATIVE = "uninformative"
    OUTSIDE = "outside"
    NOT_SUPPORTED = "not supported"
    NOT_RUN = "not run"


class VerdictClass(StrEnum):
    """The classes of the front page, in the order in which they are counted there."""

    SUPPORTED = "supported"
    WITH_CHANGES = "supported with changes (ours)"
    BY_CONSTRUCTION = "true by construction"
    UNDECIDED = "undecided"
    NOT_SUPPORTED = "not supported"
    NOT_RUN = "not run"


CLASSES: Mapping[VerdictKind, VerdictClass] = {
    **dict.fromkeys(VerdictKind, VerdictClass.UNDECIDED),
    VerdictKind.CONSISTENT: VerdictClass.SUPPORTED,
    VerdictKind.SUPPORTED: VerdictClass.SUPPORTED,
    VerdictKind.WITH_CHANGES: VerdictClass.WITH_CHANGES,
    VerdictKind.BY_CONSTRUCTION: VerdictClass.BY_CONSTRUCTION,
    VerdictKind.OUTSIDE: VerdictClass.NOT_SUPPORTED,
    VerdictKind.NOT_SUPPORTED: VerdictClass.NOT_SUPPORTED,
    VerdictKind.NOT_RUN: VerdictClass.NOT_RUN,
}
