"""Statements that compare two settings, or the paired timings of a benchmark."""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from repro.claims.evidence import Evidence, Finding, StatementPredicate
from repro.claims.selector import BenchSelector, CardSelector
from repro.claims.yaml_rows import Number, Text
from repro.results.selectors import NotRunError, like_for_like, paired_values
from repro.results.statistics import Estimate, paired_ratio


class PairedRatioBelow(StatementPredicate):
    """Member by member and like for like, each metric's ratio to `against` lies below `ratio`.

    "Below" with its whole 95 % interval; where an opponent fails the pair is won, where our member fails nothing holds.
    """

    name: Literal["paired_ratio_below"]
    where: CardSelector
    against: CardSelector
    metrics: Annotated[list[Text], Field(min_length=1)]
    ratio: Number = 1.0

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the ratios of all metrics; the greatest is shown."""
        ours, other = like_for_like(evidence.results, evidence.experiment, self.where, self.against)
        ratios, complete = {}, True
        for metric in self.metrics:
            first, second = paired_values(ours, other, metric)
            if first.size == 0:
                raise NotRunError(f"{metric} was not measured on shared seeds in {evidence.experiment}")
            ratios[metric] = paired_ratio(first, second)
            complete &= bool(np.all(np.isfinite(first)))
        holds = complete and all(_below(pairs, self.ratio) for pairs in ratios.values())
        parts = [f"{metric} ratio {_interval(pairs)}" for metric, pairs in ratios.items()]
        note = f"asked: every ratio below {self.ratio:g}; " + ", ".join(parts)
        if other.failed:
            note += f"; {other.failed} of {other.n} opponents failed"
        worst = max(ratios.values(), key=lambda pairs: pairs.median)
        return Finding.of_settings(holds, "paired ratio of " + ", ".join(ratios), "1", worst, note, ours, other)


class RatioAtLeast(StatementPredicate):
    """The median of `where` is at least `ratio` times that of `against`; their budgets may differ."""

    name: Literal["ratio_at_least"]
    where: CardSelector
    against: CardSelector
    metric: Text
    ratio: Number

    def judge(self, evidence: Evidence) -> Finding:
        """Compare the ratio of the medians."""
        ours, first = evidence.measured(self.where, self.metric)
        other, second = evidence.measured(self.against, self.metric)
        value = first.median / second.median if math.isfinite(first.median) else math.inf
        estimate = Estimate(value, math.nan, math.nan, min(first.n, second.n), first.failed + second.failed)
        note = f"asked: at least {self.ratio:g}; medians {first.median:.3g} and {second.median:.3g}"
        return Finding.of_settings(value >= self.ratio, f"ratio of {self.metric}", "1", estimate, note, ours, other)


class BenchRatioAbove(StatementPredicate):
    """In every paired timing that `bench` selects, the lower quartile of other / ours lies above `ratio`."""

    name: Literal["bench_ratio_above"]
    ratio: Number
    bench: BenchSelector

    def judge(self, evidence: Evidence) -> Finding:
        """Compare every timing; the one of the least median is shown, with its quartiles as interval."""
        rows = evidence.results.bench
        for column, value in self.bench.items():
            rows = rows[rows[column] == value]
        if rows.empty:
            selected = ", ".join(f"{column}={value}" for column, value in self.bench.items())
            raise NotRunError(f"no timing with {selected}")
        worst = rows.sort_values("ratio_median").iloc[0]
        spread = f"{rows['ratio_median'].min():.3g} to {rows['ratio_median'].max():.3g}"
        return Finding(
            bool((rows["ratio_q25"] > self.ratio).all()),
            "time ratio (other / ours)",
            "1",
            Estimate(float(worst.ratio_median), float(worst.ratio_q25), float(worst.ratio_q75), len(rows)),
            f"asked: above {self.ratio:g} in every timing; medians {spread}; quartiles of the least in brackets",
            runs=tuple(dict.fromkeys(rows["run"])),
            commands=tuple(command for command in dict.fromkeys(rows["command"]) if command),
        )


def _below(pairs: Estimate, ratio: float) -> bool:
    # With fewer than two finished pairs there is no interval: the median of won pairs (0) decides.
    return pairs.high < ratio if math.isfinite(pairs.high) else pairs.failed > 0 and pairs.median < ratio


def _interval(pairs: Estimate) -> str:
    interval = f" [{pairs.low:.3g}, {pairs.high:.3g}]" if math.isfinite(pairs.low) else ""
    return f"{pairs.median:.3g}{interval}"
