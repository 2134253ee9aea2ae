"""Whether a bound holds: decided only where the whole 95 % interval lies on one side of it."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from repro.results.statistics import Estimate

MARGIN = 1.05  # ratios nearer to 1 than this count as equal


class Ruling(StrEnum):
    """What an interval says of a bound; `DEPENDS` where readings of the paper give different answers."""

    HOLDS = "holds"
    FAILS = "fails"
    OPEN = "open"
    DEPENDS = "depends"


@dataclass(frozen=True)
class Decision:
    """The outcome, and what the point estimate alone says."""

    outcome: Ruling
    leans: bool

    @classmethod
    def certain(cls, holds: bool) -> "Decision":
        """Decided by counting: a statement about every member."""
        return cls(Ruling.HOLDS if holds else Ruling.FAILS, bool(holds))

    @classmethod
    def above(cls, estimate: Estimate, bound: float) -> "Decision":
        """Whether the estimate lies above a bound."""
        if math.isnan(estimate.low):
            return cls(Ruling.OPEN, estimate.median > bound)
        outcome = Ruling.HOLDS if estimate.low > bound else Ruling.FAILS if estimate.high <= bound else Ruling.OPEN
        return cls(outcome, estimate.median > bound)

    @classmethod
    def at_least(cls, estimate: Estimate, bound: float) -> "Decision":
        """Whether the estimate reaches a bound, to rounding."""
        return cls.above(estimate, bound - 1e-12 * max(1.0, abs(bound)))

    @classmethod
    def at_most(cls, estimate: Estimate, bound: float) -> "Decision":
        """Whether the estimate stays within a bound, to rounding."""
        return cls.below(estimate, bound + 1e-12 * max(1.0, abs(bound)))

    @classmethod
    def greater(cls, one: Estimate, other: Estimate) -> "Decision":
        """Whether one estimate lies above another, interval by interval."""
        ruling = Ruling.HOLDS if one.low > other.high else Ruling.FAILS if one.high < other.low else Ruling.OPEN
        return cls(ruling, one.median > other.median)

    @classmethod
    def below(cls, estimate: Estimate, bound: float) -> "Decision":
        """Whether the estimate lies below a bound."""
        mirrored = Estimate(-estimate.median, -estimate.high, -estimate.low, estimate.n, estimate.failed)
        return cls.above(mirrored, -bound)

    @classmethod
    def of_all(cls, decisions: Iterable["Decision"]) -> "Decision":
        """Whether all hold: one that fails decides, one that is open leaves it open."""
        parts = list(decisions)
        outcomes = {part.outcome for part in parts}
        outcome = next((o for o in (Ruling.FAILS, Ruling.DEPENDS, Ruling.OPEN) if o in outcomes), Ruling.HOLDS)
        return cls(outcome, all(part.leans for part in parts))
