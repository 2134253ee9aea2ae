import math

import numpy as np
import pytest

from repro.results.statistics import (
    estimate,
    median_interval,
    paired_ratio,
    prediction_interval,
    share,
    wilson_interval,
)


@pytest.mark.parametrize(("n", "place"), [(6, 1), (8, 1), (9, 2), (10, 2), (20, 6), (40, 14)])
def test_the_interval_of_a_median_is_that_of_the_tables(n, place):
    # Places of the 95 % interval of a median: Conover (1999), table A3, and the binomial distribution itself.
    assert median_interval(np.arange(1.0, n + 1)) == (place, n + 1 - place)


def test_five_members_give_their_range_and_fewer_no_interval():
    assert median_interval([5.0, 1, 3, 2, 4]) == (1, 5)
    assert all(math.isnan(end) for end in median_interval([1.0, 2, 3, 4]))


@pytest.mark.parametrize("draw", ["lognormal", "bimodal"])
def test_the_interval_covers_the_median_whatever_the_distribution(draw):
    rng = np.random.default_rng(0)
    samples = rng.lognormal(sigma=2.0, size=(4000, 10))
    if draw == "bimodal":
        samples = np.where(rng.uniform(size=samples.shape) < 0.7, 1 + samples, 1e-6 * samples)
    true = np.median(samples)
    intervals = np.array([median_interval(sample) for sample in samples])
    covered = np.mean((intervals[:, 0] <= true) & (true <= intervals[:, 1]))
    assert covered == pytest.approx(0.9785, abs=0.01)  # of [x2, x9]: 1 - 22 / 1024


@pytest.mark.parametrize(("n", "sigma"), [(3, 1.0), (10, 1.0), (60, 0.5)])
def test_one_more_draw_falls_into_the_prediction_interval_at_its_nominal_rate(n, sigma):
    draws = np.random.default_rng(n).lognormal(sigma=sigma, size=(4000, n + 1))
    intervals = np.array([prediction_interval(draw[:-1], log=True) for draw in draws])
    inside = np.mean((intervals[:, 0] <= draws[:, -1]) & (draws[:, -1] <= intervals[:, 1]))
    assert inside == pytest.approx(0.955 if n == 60 else 0.95, abs=0.012)


def test_a_prediction_leaves_failed_members_out_and_needs_two():
    assert prediction_interval([1.0, 2.0, math.inf], log=True) == prediction_interval([2.0, 1.0], log=True)
    assert math.isnan(prediction_interval([1.0], log=False)[0])


def test_the_wilson_interval_matches_published_values():
    # Newcombe (1998), table I: 81/263 -> 0.2553 to 0.3662; 0/20 -> 0 to 0.1611.
    assert wilson_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson_interval(20, 20)[1] == 1.0


def test_failed_members_stay_in_the_median():
    spread = estimate([0.1, 0.2, math.nan])
    assert (spread.median, spread.n, spread.failed) == (0.2, 3, 1)
    assert estimate([0.1, math.nan, math.nan]).median == math.inf
    assert estimate([0.1, math.inf]).median == math.inf


def test_a_failed_member_is_an_end_of_the_interval():
    spread = estimate([0.1, 0.2, 0.3, 0.4, math.nan])
    assert (spread.low, spread.high) == (0.1, math.inf)
    assert estimate([0.1, 0.2, 0.3, 0.4, math.nan], failed_is=-math.inf).low == -math.inf


def test_a_share_has_a_wilson_interval():
    found = share([True, True, False, True])
    assert found.median == 0.75
    assert (found.low, found.high) == wilson_interval(3, 4)
    assert share([0.5, 1.0, 1.0, 0.5]) == found


def test_the_paired_ratio_removes_what_the_pair_shares():
    common = np.random.default_rng(1).lognormal(sigma=3.0, size=8)
    ratio = paired_ratio(0.5 * common, common)
    assert (ratio.median, ratio.low, ratio.high) == pytest.approx((0.5, 0.5, 0.5))


def test_a_failed_opponent_is_a_won_pair_and_a_failed_member_a_lost_one():
    won = paired_ratio([0.1, 0.1, 0.1], [math.nan, math.nan, 0.2])
    assert (won.median, won.failed) == (0.0, 2)
    assert paired_ratio([math.nan, math.nan, 0.1], [0.1, 0.1, 0.2]).median == math.inf
    assert math.isnan(paired_ratio([math.nan], [math.nan]).median)
