"""Intervals that hold at five seeds: Student-t (on the log scale for errors), Wilson for shares, pairs by seed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

LEVEL = 0.95


@dataclass(frozen=True)
class Estimate:
    """A median over members with its 95 % interval; `failed` of the `n` members gave no finite value."""

    median: float
    low: float
    high: float
    n: int
    failed: int = 0


NOTHING = Estimate(math.nan, math.nan, math.nan, 0)


def student_t_interval(values: ArrayLike, *, log: bool, level: float = LEVEL) -> tuple[float, float]:
    """Return the Student-t interval of the mean (log: of the geometric mean); nan for fewer than two values."""
    sample = np.asarray(values, dtype=float)
    if sample.size < 2:
        return math.nan, math.nan
    if log:
        low, high = student_t_interval(np.log(sample), log=False, level=level)
        return math.exp(low), math.exp(high)
    half = _t_quantile(sample.size - 1, level) * sample.std(ddof=1) / math.sqrt(sample.size)
    centre = sample.mean()
    return float(centre - half), float(centre + half)


def wilson_interval(successes: int, n: int, *, level: float = LEVEL) -> tuple[float, float]:
    """Return the Wilson score interval of a share (Wilson 1927); nan without trials."""
    from scipy.special import ndtri

    if n == 0:
        return math.nan, math.nan
    z = float(ndtri(0.5 + level / 2))
    share = successes / n
    centre = (share + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z * math.sqrt(share * (1 - share) / n + z**2 / (4 * n**2)) / (1 + z**2 / n)
    # At zero and at all successes an end is exactly 0 or 1: say so, not what rounding leaves of it.
    return (0.0 if successes == 0 else centre - half), (1.0 if successes == n else centre + half)


def paired_ratio(ours: ArrayLike, other: ArrayLike) -> Estimate:
    """Return the paired ratio ours / other with its t interval on the log scale; a failed partner makes it 0 or inf.

    Both (pairs,), positive. The interval is that of the pairs where both members finished; the median counts all.
    A pair in which both failed says nothing and counts only under `failed`.
    """
    first, second = np.asarray(ours, dtype=float), np.asarray(other, dtype=float)
    finished = np.isfinite(first) & np.isfinite(second)
    ratios = np.full(first.shape, math.nan)
    ratios[finished] = first[finished] / second[finished]
    ratios[np.isfinite(first) & ~np.isfinite(second)] = 0.0
    ratios[~np.isfinite(first) & np.isfinite(second)] = math.inf
    known = ratios[~np.isnan(ratios)]
    if known.size == 0:
        return Estimate(math.nan, math.nan, math.nan, first.size, first.size)
    positive = bool(np.all(ratios[finished] > 0))
    low, high = student_t_interval(ratios[finished], log=positive)
    return Estimate(_median(known), low, high, first.size, int(first.size - finished.sum()))


def estimate(values: ArrayLike, *, log: bool, failed_is: float = math.inf) -> Estimate:
    """Summarise members, (member,): failed ones (not finite) count in the median as `failed_is`, never as absent.

    The interval is that of the members that finished, on the log scale where all of these are positive.
    """
    sample = np.asarray(values, dtype=float)
    if sample.size == 0:
        return NOTHING
    finite = sample[np.isfinite(sample)]
    low, high = student_t_interval(finite, log=log and bool(np.all(finite > 0)))
    median = _median(np.where(np.isfinite(sample), sample, failed_is))
    return Estimate(median, low, high, sample.size, int(sample.size - finite.size))


def share(outcomes: Sequence[bool] | np.ndarray) -> Estimate:
    """Summarise yes/no outcomes, (member,): the share of yes with its Wilson interval."""
    n, successes = len(outcomes), int(np.sum(outcomes))
    if n == 0:
        return NOTHING
    return Estimate(successes / n, *wilson_interval(successes, n), n)


def _median(sample: np.ndarray) -> float:
    # np.median warns at inf - inf; of an even number of members between finite and infinite, the median is infinite.
    ordered = np.sort(sample)
    lower, upper = float(ordered[(ordered.size - 1) // 2]), float(ordered[ordered.size // 2])
    return lower if lower == upper else (lower + upper) / 2


def _t_quantile(degrees: int, level: float) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(degrees, 0.5 + level / 2))
