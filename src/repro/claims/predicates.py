"""The vocabulary in which a statement of the paper is asked of stored runs: true is matched, false not reproduced."""

import math
from dataclasses import dataclass

import numpy as np

from repro.results.results import Results
from repro.results.selectors import (
    TRIVIAL,
    NotRunError,
    Setting,
    Where,
    anchor,
    like_for_like,
    one_setting,
    paired_values,
    test_set_of,
)
from repro.results.statistics import Estimate, paired_ratio, share


@dataclass(frozen=True)
class Evidence:
    """Where a predicate looks: the results, and the experiment that answers the claim."""

    results: Results
    experiment: str


@dataclass(frozen=True)
class Outcome:
    """What a predicate found: whether it holds, the quantity it looked at, and the settings or benches behind it."""

    holds: bool
    quantity: str
    unit: str
    estimate: Estimate
    note: str = ""
    settings: tuple[Setting, ...] = ()
    runs: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()


def median_below(evidence: Evidence, *, metric: str, value: float, where: Where) -> Outcome:
    """Hold when the median member lies below `value`."""
    setting, found = _measured(evidence, where, metric)
    return _outcome(found.median < value, metric, setting, found, f"asked: below {value:g}")


def median_above(evidence: Evidence, *, metric: str, value: float, where: Where) -> Outcome:
    """Hold when the median member lies above `value`."""
    setting, found = _measured(evidence, where, metric)
    return _outcome(found.median > value, metric, setting, found, f"asked: above {value:g}")


def all_members_below(evidence: Evidence, *, metric: str, value: float, where: Where) -> Outcome:
    """Hold when every member lies below `value`; a failed member does not."""
    setting, found = _measured(evidence, where, metric)
    members = setting.values(metric)
    return _outcome(bool(np.all(members < value)), metric, setting, found, f"asked: every member below {value:g}")


def all_members_away_from(evidence: Evidence, *, metric: str, value: float, distance: float, where: Where) -> Outcome:
    """Hold when every member that finished lies at least `distance` from `value`."""
    setting, found = _measured(evidence, where, metric)
    members = setting.values(metric)
    finished = members[np.isfinite(members)]
    holds = finished.size > 0 and bool(np.all(np.abs(finished - value) >= distance))
    return _outcome(holds, metric, setting, found, f"asked: every member {distance:g} or more away from {value:g}")


def share_at_least(evidence: Evidence, *, metric: str, share_of_members: float, where: Where) -> Outcome:
    """Hold when at least this share of the members has the property (a 0/1 metric)."""
    setting, found = _measured(evidence, where, metric)
    return _outcome(found.median >= share_of_members, metric, setting, found, f"asked: at least {share_of_members:g}")


def share_of_failures_at_least(evidence: Evidence, *, share_of_members: float, where: Where) -> Outcome:
    """Hold when at least this share of the fits fails.

    A fit fails when it diverges, ends worse than the trivial model in MAE q̈, or has min eig M <= 0.
    """
    setting = one_setting(evidence.results, evidence.experiment, where)
    errors, least = setting.values("mae_qdd"), setting.values("min_eig_M")
    if errors.size == 0:
        raise NotRunError(f"mae_qdd was not measured in {evidence.experiment}")
    trivial = anchor(evidence.results, evidence.experiment, TRIVIAL, test_set_of(setting.card))
    bound = trivial.estimate("mae_qdd").median if trivial else math.inf
    # A failed member is nan, for which no comparison holds.
    fine = errors <= bound
    if least.size:
        fine &= least > 0
    found = share(~fine)
    causes = [
        f"{setting.failed} diverged",
        f"{int(np.sum(errors > bound))} worse than the trivial model" if trivial else "trivial model not run",
        f"{int(np.sum(least <= 0))} with an indefinite mass matrix" if least.size else "min eig M not measured",
    ]
    note = f"asked: at least {share_of_members:g}; of {setting.n} members: " + ", ".join(causes)
    return Outcome(found.median >= share_of_members, "share of failed fits", "1", found, note, (setting,))


def paired_ratio_below(
    evidence: Evidence, *, metrics: list[str], where: Where, against: Where, ratio: float = 1.0
) -> Outcome:
    """Hold when, member by member and like for like, each metric's ratio to `against` lies below `ratio`.

    "Below" with its whole 95 % interval; where an opponent fails the pair is won, where our member fails nothing holds.
    """
    ours, other = like_for_like(evidence.results, evidence.experiment, where, against)
    found = {}
    for metric in metrics:
        first, second = paired_values(ours, other, metric)
        if first.size == 0:
            raise NotRunError(f"{metric} was not measured on shared seeds in {evidence.experiment}")
        found[metric] = (paired_ratio(first, second), bool(np.all(np.isfinite(first))))
    holds = all(_below(pairs, ratio) and complete for pairs, complete in found.values())
    parts = [f"{metric} ratio {_spell(pairs)}" for metric, (pairs, _) in found.items()]
    note = f"asked: every ratio below {ratio:g}; " + ", ".join(parts)
    if other.failed:
        note += f"; {other.failed} of {other.n} opponents failed"
    worst = max((pairs for pairs, _ in found.values()), key=lambda pairs: pairs.median)
    return Outcome(holds, "paired ratio of " + ", ".join(metrics), "1", worst, note, (ours, other))


def ratio_at_least(evidence: Evidence, *, metric: str, where: Where, against: Where, ratio: float) -> Outcome:
    """Hold when the median of `where` is at least `ratio` times that of `against` (unlike budgets allowed)."""
    ours, first = _measured(evidence, where, metric)
    other, second = _measured(evidence, against, metric)
    value = math.inf if not math.isfinite(first.median) else first.median / second.median
    found = Estimate(value, math.nan, math.nan, min(first.n, second.n), first.failed + second.failed)
    note = f"asked: at least {ratio:g}; medians {first.median:.3g} and {second.median:.3g}"
    return Outcome(value >= ratio, f"ratio of {metric}", "1", found, note, (ours, other))


def bench_ratio_above(evidence: Evidence, *, ratio: float, bench: Where) -> Outcome:
    """Hold when in every paired timing chosen the lower quartile of other / ours lies above `ratio`."""
    rows = evidence.results.bench
    for column, value in bench.items():
        rows = rows[rows[column] == value]
    if rows.empty:
        raise NotRunError("no timing with " + ", ".join(f"{column}={value}" for column, value in bench.items()))
    worst = rows.sort_values("ratio_median").iloc[0]
    found = Estimate(float(worst.ratio_median), float(worst.ratio_q25), float(worst.ratio_q75), len(rows))
    spread = f"{rows['ratio_median'].min():.3g} to {rows['ratio_median'].max():.3g}"
    note = f"asked: above {ratio:g} in every timing; medians {spread}; quartiles of the least in brackets"
    return Outcome(
        bool((rows["ratio_q25"] > ratio).all()),
        "time ratio (other / ours)",
        "1",
        found,
        note,
        runs=tuple(dict.fromkeys(rows["run"])),
        commands=tuple(command for command in dict.fromkeys(rows["command"]) if command),
    )


def _measured(evidence: Evidence, where: Where, metric: str) -> tuple[Setting, Estimate]:
    setting = one_setting(evidence.results, evidence.experiment, where)
    found = setting.estimate(metric)
    if found.n == 0:
        raise NotRunError(f"{metric} was not measured in {evidence.experiment}")
    return setting, found


def _outcome(holds: bool, metric: str, setting: Setting, found: Estimate, note: str) -> Outcome:
    return Outcome(bool(holds), metric, setting.unit(metric), found, note, (setting,))


def _below(pairs: Estimate, ratio: float) -> bool:
    # With fewer than two finished pairs there is no interval: the median of won pairs (0) decides.
    return pairs.high < ratio if math.isfinite(pairs.high) else pairs.failed > 0 and pairs.median < ratio


def _spell(pairs: Estimate) -> str:
    interval = f" [{pairs.low:.3g}, {pairs.high:.3g}]" if math.isfinite(pairs.low) else ""
    return f"{pairs.median:.3g}{interval}"
