"""Statements that compare two settings, or the paired timings of a benchmark."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from repro.claims.evidence import BenchSelector, CardSelector, Decision, Evidence, Finding, StatementPredicate
from repro.claims.yaml_rows import Number, Text
from repro.results.selectors import NotRunError, in_words, like_for_like, paired_values
from repro.results.statistics import FEWEST, Estimate, paired_ratio
from repro.results.table_schema import records
from repro.tracking.lazy_pandas import pd

MARGIN = 1.05  # ratios nearer to 1 than this count as equal


class PairedRatioBelow(StatementPredicate):
    """Member by member and like for like, each metric's ratio to `against` lies below `ratio` by the practical margin.

    `allow_equal`: not above it by more than the margin. A failed opponent makes a ratio 0, a failed member of ours inf.
    """

    name: Literal["paired_ratio_below"]
    where: CardSelector
    against: CardSelector
    metrics: Annotated[list[Text], Field(min_length=1)]
    ratio: Number = 1.0
    allow_equal: bool = False

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the ratios of all metrics; the greatest is shown."""
        ours, other = like_for_like(evidence.results, evidence.experiment, self.where, self.against)
        ratios = {}
        for metric in self.metrics:
            first, second = paired_values(ours, other, metric)
            if first.size == 0:
                raise NotRunError(f"{metric} was not measured on shared seeds in {evidence.experiment}")
            ratios[metric] = paired_ratio(first, second)
        bound = self.ratio * MARGIN if self.allow_equal else self.ratio / MARGIN
        decision = Decision.of_all(Decision.below(pairs, bound) for pairs in ratios.values())
        parts = [f"{metric} ratio {_interval(pairs)}" for metric, pairs in ratios.items()]
        note = f"criterion: every ratio below {bound:.3g}; " + ", ".join(parts)
        if other.failed:
            note += f"; {other.failed} of {other.n} opponents failed"
        worst = max(ratios.values(), key=lambda pairs: pairs.median)
        rows = (*ours.rows, *other.rows)
        return Finding("paired ratio of " + ", ".join(ratios), "1", worst, note, rows, decision=decision)


class RatioAtLeast(StatementPredicate):
    """The median of `where` is `ratio` times that of `against` or more, by the practical margin; budgets may differ.

    The interval of the ratio is that of the ends of both intervals: wide, as nothing pairs the members.
    """

    name: Literal["ratio_at_least"]
    where: CardSelector
    against: CardSelector
    metric: Text
    ratio: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the ratio of the medians."""
        ours, first = evidence.measured(self.where, self.metric)
        other, second = evidence.measured(self.against, self.metric)
        estimate = Estimate(
            _quotient(first.median, second.median),
            _quotient(first.low, second.high),
            _quotient(first.high, second.low),
            min(first.n, second.n),
            first.failed + second.failed,
        )
        bound = self.ratio * MARGIN
        note = f"criterion: above {bound:.3g}; medians {first.median:.3g} and {second.median:.3g}"
        rows, decision = (*ours.rows, *other.rows), Decision.above(estimate, bound)
        return Finding(f"ratio of {self.metric}", "1", estimate, note, rows, decision=decision)


class BenchRatioAbove(StatementPredicate):
    """The paired timings that `bench` selects have other / ours above `ratio` by the practical margin, all of them.

    Of single steps, one per problem size, the interval goes from the least lower to the greatest upper quartile. Of
    trainings to an accuracy it goes over all starts of every accuracy that the better contender reached from as many
    starts as an interval needs; where there is none, of those that it reached from most starts.
    """

    name: Literal["bench_ratio_above"]
    ratio: Number
    bench: BenchSelector

    def judge(self, evidence: Evidence) -> Finding:
        """Compare all timings; the least median is shown."""
        rows = evidence.results.bench
        for column, value in self.bench.items():
            rows = rows[rows[column] == value]
        if rows.empty:
            raise NotRunError(f"no timing with {in_words(self.bench)}")
        of_steps = rows["metric"] == ""
        starts = rows[["ours_reached", "other_reached"]].max(axis=1).where(~of_steps, 1).astype(int)
        enough = of_steps | (starts >= min(FEWEST, starts.max()))
        judged, starts = rows[enough], starts[enough]
        low = judged["ratio_q25"].where(of_steps, judged["ratio_least"]).min(skipna=False)
        high = judged["ratio_q75"].where(of_steps, judged["ratio_greatest"]).max(skipna=False)
        medians, n = judged["ratio_median"], judged["size"].nunique() * int(starts.min())
        estimate = Estimate(float(medians.min()), float(low), float(high), n)
        bound = self.ratio * MARGIN
        place, ends = "problem size", "the least lower and the greatest upper quartile"
        if not of_steps.any():
            place, ends = "accuracy", "; ".join(["the least and the greatest of all starts", *_accuracies(rows)])
        note = (
            f"criterion: above {bound:.3g} at every {place}; medians {medians.min():.3g} to {medians.max():.3g}; "
            f"in brackets {ends}"
        )
        decision = Decision.above(estimate, bound)
        return Finding("time ratio (other / ours)", "1", estimate, note, records(rows), decision=decision)


RatioPredicate = PairedRatioBelow | RatioAtLeast | BenchRatioAbove


def _accuracies(rows: "pd.DataFrame") -> Iterator[str]:
    for row in rows.to_dict("records"):
        ratio = "no ratio" if math.isnan(row["ratio_median"]) else f"{row['ratio_median']:.3g}"
        reached = f"{row['ours_reached']} and {row['other_reached']} of {row['starts']} starts"
        yield f"{row['metric']} {row['goal']:g} {ratio}, reached from {reached}"


def _quotient(numerator: float, denominator: float) -> float:
    return numerator / denominator if math.isfinite(numerator) else numerator


def _interval(pairs: Estimate) -> str:
    interval = f" [{pairs.low:.3g}, {pairs.high:.3g}]" if math.isfinite(pairs.low) else ""
    return f"{pairs.median:.3g}{interval}"
