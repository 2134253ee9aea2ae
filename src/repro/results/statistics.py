"""Intervals that hold at five members: order statistics of medians, Wilson's of shares, and of one more draw."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

LEVEL = 0.95
BY_RANK = 39  # values between whose least and greatest one more falls with LEVEL, whatever the distribution
FEWEST = 5  # members, starts or problem sizes that an interval needs


@dataclass(frozen=True)
class Estimate:
    """A median over members with its 95 % interval; `failed` of the `n` members gave no finite value."""

    median: float
    low: float
    high: float
    n: int
    failed: int = 0


NOTHING = Estimate(math.nan, math.nan, math.nan, 0)


def median_interval(values: ArrayLike) -> tuple[float, float]:
    """Return the interval of the median between two order statistics, for any distribution (Thompson 1936).

    The narrowest [x_k, x_{n+1-k}] that covers it with LEVEL; of five values both ends (93.75 %); nan for fewer.
    """
    from scipy.special import bdtr

    ordered = np.sort(np.asarray(values, dtype=float))
    if ordered.size < FEWEST:
        return math.nan, math.nan
    outside = bdtr(np.arange(ordered.size // 2), ordered.size, 0.5)
    place = max(int(np.sum(outside <= (1 - LEVEL) / 2)) - 1, 0)
    return float(ordered[place]), float(ordered[-1 - place])


def prediction_interval(values: ArrayLike, *, log: bool) -> tuple[float, float]:
    """Return where one more draw falls with probability LEVEL; nan for fewer than two finite values.

    Between two order statistics where there are enough (BY_RANK at 95 %), whatever the distribution; else by Student's
    t, of the logarithms where `log` and all are positive.
    """
    from scipy.special import stdtrit

    sample = np.sort(np.asarray(values, dtype=float))
    sample = sample[np.isfinite(sample)]
    if sample.size < 2:
        return math.nan, math.nan
    if (place := math.floor((sample.size + 1) * (1 - LEVEL) / 2 + 1e-9)) >= 1:
        return float(sample[place - 1]), float(sample[-place])
    if log and sample[0] > 0:
        low, high = prediction_interval(np.log(sample), log=False)
        return math.exp(low), math.exp(high)
    half = stdtrit(sample.size - 1, 0.5 + LEVEL / 2) * sample.std(ddof=1) * math.sqrt(1 + 1 / sample.size)
    return float(sample.mean() - half), float(sample.mean() + half)


def wilson_interval(successes: float, n: int) -> tuple[float, float]:
    """Return the Wilson score interval of a share (Wilson 1927); nan without trials."""
    from scipy.special import ndtri

    if n == 0:
        return math.nan, math.nan
    z = float(ndtri(0.5 + LEVEL / 2))
    share = successes / n
    centre = (share + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z * math.sqrt(share * (1 - share) / n + z**2 / (4 * n**2)) / (1 + z**2 / n)
    # At zero and at all successes an end is exactly 0 or 1: say so, not what rounding leaves of it.
    return (0.0 if successes == 0 else centre - half), (1.0 if successes == n else centre + half)


def paired_ratio(ours: ArrayLike, other: ArrayLike) -> Estimate:
    """Return the median paired ratio ours / other with its interval; a failed partner makes a ratio 0 or inf.

    Both (pairs,), positive. A pair in which both failed says nothing and counts only under `failed`.
    """
    first, second = np.asarray(ours, dtype=float), np.asarray(other, dtype=float)
    finished = np.isfinite(first) & np.isfinite(second)
    ratios = np.where(np.isfinite(first), 0.0, np.where(np.isfinite(second), math.inf, math.nan))
    ratios[finished] = first[finished] / second[finished]
    known = ratios[~np.isnan(ratios)]
    failed = int(np.sum(~finished))
    if known.size == 0:
        return Estimate(math.nan, math.nan, math.nan, first.size, failed)
    return Estimate(_median(known), *median_interval(known), first.size, failed)


def estimate(values: ArrayLike, *, failed_is: float = math.inf) -> Estimate:
    """Summarise members, (member,): failed ones (not finite) count as `failed_is`, never as absent."""
    sample = np.asarray(values, dtype=float)
    if sample.size == 0:
        return NOTHING
    finite = np.isfinite(sample)
    counted = np.where(finite, sample, failed_is)
    return Estimate(_median(counted), *median_interval(counted), sample.size, int(np.sum(~finite)))


def share(outcomes: Sequence[float] | np.ndarray) -> Estimate:
    """Summarise outcomes of independent units, (unit,), yes or no or a share each: their mean with its Wilson interval.

    A share between 0 and 1 varies no more than a yes or no of the same mean, so that the interval is safe for it too.
    """
    n, successes = len(outcomes), float(np.sum(outcomes))
    if n == 0:
        return NOTHING
    return Estimate(successes / n, *wilson_interval(successes, n), n)


def _median(sample: np.ndarray) -> float:
    # np.median warns at inf - inf; of an even number of members between finite and infinite, the median is infinite.
    ordered = np.sort(sample)
    lower, upper = float(ordered[(ordered.size - 1) // 2]), float(ordered[ordered.size // 2])
    return lower if lower == upper else (lower + upper) / 2
