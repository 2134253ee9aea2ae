import math

import numpy as np
import pytest

from repro.results.statistics import estimate, paired_ratio, share, student_t_interval, wilson_interval


def test_the_t_interval_is_the_textbook_one():
    # n = 5, mean 3, s = sqrt(2.5); t(0.975, 4) = 2.776445 (any table of the t distribution).
    half = 2.776445 * math.sqrt(2.5) / math.sqrt(5)
    assert student_t_interval([1, 2, 3, 4, 5], log=False) == pytest.approx((3 - half, 3 + half), rel=1e-6)


def test_the_log_interval_is_the_interval_of_the_logarithms():
    low, high = student_t_interval(np.exp([1.0, 2, 3, 4, 5]), log=True)
    plain = student_t_interval([1.0, 2, 3, 4, 5], log=False)
    assert (math.log(low), math.log(high)) == pytest.approx(plain)


def test_one_member_has_no_interval():
    low, high = student_t_interval([0.3], log=True)
    assert math.isnan(low)
    assert math.isnan(high)
    assert estimate([0.3], log=True).median == 0.3


@pytest.mark.parametrize("n", [3, 5, 10])
def test_the_log_interval_covers_the_geometric_mean_of_skewed_errors_at_its_nominal_rate(n):
    draws = np.random.default_rng(0).lognormal(mean=-1.0, sigma=1.2, size=(4000, n))
    intervals = np.array([student_t_interval(draw, log=True) for draw in draws])
    covered = np.mean((intervals[:, 0] < math.exp(-1)) & (math.exp(-1) < intervals[:, 1]))
    assert covered == pytest.approx(0.95, abs=0.012)  # three standard errors of 4000 draws


def test_the_wilson_interval_matches_published_values():
    # Newcombe (1998), table I: 81/263 -> 0.2553 to 0.3662; 0/20 -> 0 to 0.1611.
    assert wilson_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson_interval(20, 20)[1] == 1.0


def test_failed_members_stay_in_the_median():
    spread = estimate([0.1, 0.2, math.nan], log=True)
    assert (spread.median, spread.n, spread.failed) == (0.2, 3, 1)
    assert estimate([0.1, math.nan, math.nan], log=True).median == math.inf
    assert estimate([0.1, math.inf], log=True).median == math.inf


def test_zeros_are_summarised_without_a_logarithm():
    exact = estimate([0.0, 0.0, 3.0], log=True)
    assert exact.low < 0 < exact.high


def test_a_share_has_a_wilson_interval():
    found = share([True, True, False, True])
    assert found.median == 0.75
    assert (found.low, found.high) == wilson_interval(3, 4)


def test_the_paired_ratio_removes_what_the_pair_shares():
    common = np.random.default_rng(1).lognormal(sigma=3.0, size=8)
    ratio = paired_ratio(0.5 * common, common)
    assert (ratio.median, ratio.low, ratio.high) == pytest.approx((0.5, 0.5, 0.5))


def test_a_failed_opponent_is_a_won_pair_and_a_failed_member_a_lost_one():
    won = paired_ratio([0.1, 0.1, 0.1], [math.nan, math.nan, 0.2])
    assert (won.median, won.failed) == (0.0, 2)
    assert paired_ratio([math.nan, math.nan, 0.1], [0.1, 0.1, 0.2]).median == math.inf
    assert math.isnan(paired_ratio([math.nan], [math.nan]).median)
