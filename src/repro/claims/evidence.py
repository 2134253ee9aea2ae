"""What a predicate selects and is judged on, whether its bound holds, and the base of all predicates."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated

from pydantic import AfterValidator

from repro.claims.yaml_rows import YamlRow
from repro.results.results import Results
from repro.results.run_setting import FromRuns, RunSetting
from repro.results.selectors import NotRunError, Where, one_setting
from repro.results.statistics import Estimate
from repro.results.table_schema import CARD, TABLES, Row

# Columns of a result table or settings, and the value or values that a run must have there.
Value = bool | int | float | str
Selector = dict[str, Value | list[Value]]


def _columns_of(columns: Collection[str], settings: bool = True) -> Callable[[Selector], Selector]:
    def checked(selector: Selector) -> Selector:
        unknown = sorted(name for name in selector if name not in columns and not (settings and "." in name))
        if unknown:
            dotted = ", and settings by their dotted keys, such as model.hidden" if settings else ""
            raise ValueError(f"has no column {', '.join(unknown)}; allowed are {', '.join(columns)}{dotted}")
        return selector

    return checked


CardSelector = Annotated[Selector, AfterValidator(_columns_of(CARD))]
LoopSelector = Annotated[Selector, AfterValidator(_columns_of(TABLES["control"]))]
BenchSelector = Annotated[Selector, AfterValidator(_columns_of(TABLES["bench"], settings=False))]


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
        """Whether the estimate lies above a bound; open too where it has no interval (its ends are nan)."""
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


@dataclass(frozen=True)
class Evidence:
    """Where a predicate looks: the results, and the experiment that answers the claim."""

    results: Results
    experiment: str

    def measured(self, where: Where, metric: str) -> tuple[RunSetting, Estimate]:
        """The one setting that a selector means, and the estimate of its metric; NotRunError where there is none."""
        setting = one_setting(self.results, self.experiment, where)
        estimate = setting.estimate(metric)
        if estimate.n == 0:
            raise NotRunError(f"{metric} was not measured in {self.experiment}")
        return setting, estimate

    def run_rows(self, runs: Iterable[str]) -> list[Row]:
        """The rows of the runs table for these runs."""
        wanted = set(runs)
        return [row for row in self.results.rows if row["run"] in wanted]


@dataclass(frozen=True)
class Answer(FromRuns):
    """What stored runs say: a quantity with its estimate, and the rows of the result tables behind it."""

    quantity: str
    unit: str
    estimate: Estimate
    note: str = ""
    rows: Sequence[Row] = ()
    other: Estimate | None = None  # what the estimate is compared with, where that was measured too


@dataclass(frozen=True)
class Finding(Answer):
    """What a predicate decides."""

    decision: Decision = field(kw_only=True)


class StatementPredicate(YamlRow, ABC):
    """One kind of statement; its fields are the parameters that a claim gives, `name` among them."""

    name: str

    @property
    def selectors(self) -> list[Selector]:
        """What selects the runs that it is judged on; none where it is about timings."""
        return [value for field, value in self if field in ("where", "against", "loops", "other_loops") and value]

    @abstractmethod
    def judge(self, evidence: Evidence) -> Finding:
        """Decide it on stored runs. Raises NotRunError where no run answers."""
