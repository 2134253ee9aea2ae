"""Timing in pairs, on a clock that the contenders move themselves."""

import gc
import math
from dataclasses import replace

import numpy as np
import pytest

from repro.bench.pairing import Pairs, Rounds, interleaved


class Stage:
    """A clock, and contenders that take a given time each call."""

    def __init__(self):
        self.now, self.calls = 0.0, ""

    def contender(self, name, seconds):
        def call():
            self.calls += name
            self.now += seconds(self.now) if callable(seconds) else seconds

        return call

    def clock(self):
        return self.now


@pytest.fixture
def stage():
    return Stage()


def test_contenders_take_turns_after_a_warm_up(stage):
    rounds = Rounds(least=3, most=3, limit_s=0.0, shortest_s=0.0)
    pairs = interleaved(stage.contender("A", 1.0), stage.contender("B", 4.0), rounds, stage.clock)
    assert stage.calls.endswith("ABABAB")
    assert set(stage.calls[:-6]) == {"A", "B"}
    np.testing.assert_allclose(pairs.ours, 1.0)
    np.testing.assert_allclose(pairs.ratios, 4.0)


def test_a_machine_that_slows_down_moves_times_but_not_ratios(stage):
    def slower(seconds):
        return lambda now: seconds * (1 + now / 1e4)

    rounds = Rounds(least=200, most=200, limit_s=0.0, shortest_s=0.0)
    summary = interleaved(stage.contender("A", slower(1)), stage.contender("B", slower(3)), rounds, stage.clock)
    assert summary.ours[-1] > 1.05 * summary.ours[0]
    assert summary.summary()["ratio_median"] == pytest.approx(3, rel=1e-3)
    assert summary.summary()["ratio_q75"] == pytest.approx(summary.summary()["ratio_q25"], rel=1e-3)


def test_a_quick_contender_is_repeated_within_one_timing(stage):
    rounds = Rounds(least=1, most=1, limit_s=0.0, shortest_s=0.01)
    pairs = interleaved(stage.contender("A", 0.001), stage.contender("B", 0.02), rounds, stage.clock)
    assert stage.calls.endswith("A" * 10 + "B")
    assert pairs.ours[0] == pytest.approx(0.001)


@pytest.mark.parametrize(("limit_s", "expected"), [(0.0, 2), (11.0, 6), (1e9, 8)])
def test_rounds_end_by_number_or_time(stage, limit_s, expected):
    rounds = Rounds(least=2, most=8, limit_s=limit_s, shortest_s=0.0)
    assert len(interleaved(stage.contender("A", 1.0), stage.contender("B", 1.0), rounds, stage.clock)) == expected


def test_the_garbage_collector_rests_during_the_timings_only(stage):
    seen = []
    interleaved(lambda: seen.append(gc.isenabled()), lambda: None, Rounds(3, 3, 0.0, 0.0), stage.clock)
    assert seen[-3:] == [False] * 3
    assert gc.isenabled()


def test_summary_holds_the_quartiles_of_the_ratio_pair_by_pair():
    pairs = Pairs(np.array([1.0, 1.0, 1.0, 1.0]) / 1e3, np.array([8.0, 2.0, 6.0, 4.0]) / 1e3)
    expected = {"ratio_q25": 2, "ratio_median": 4, "ratio_q75": 6, "ours_ms": 1, "other_ms": 4}
    expected |= {"ratio_least": 2, "ratio_greatest": 8}
    memory = {"ours_mib": 7, "other_mib": 0.5}
    assert replace(pairs, ours_mib=7, other_mib=0.5).summary() == pytest.approx(expected | memory)
    assert pairs.summary() == pytest.approx(expected | dict.fromkeys(memory, math.nan), nan_ok=True)


def test_a_goal_that_only_one_reaches_is_an_infinite_or_zero_ratio():
    pairs = Pairs(np.array([1.0, math.inf, math.inf, 2.0]), np.array([math.inf, math.inf, 5.0, 8.0]))
    np.testing.assert_array_equal(pairs.ratios, [math.inf, 0.0, 4.0])
    assert pairs.summary()["ratio_median"] == 4.0
    assert pairs.summary()["ratio_q75"] == math.inf
    assert pairs.summary()["ours_ms"] == 2000.0


def test_a_goal_that_nobody_reaches_gives_no_ratio():
    never = np.full(3, math.inf)
    assert math.isnan(Pairs(never, never).summary()["ratio_median"])
