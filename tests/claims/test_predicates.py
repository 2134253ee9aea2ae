import math

import pytest
from pydantic import TypeAdapter

from repro.claims.claims import Predicate
from repro.claims.evidence import Evidence
from repro.results.selectors import NotRunError

T2 = {"basis": "t2", "objective": "inverse"}
FORWARD = {"basis": "t2", "objective": "forward"}


def judged(store, name, **parameters):
    predicate = TypeAdapter(Predicate).validate_python({"name": name, **parameters})
    return predicate.judge(Evidence(store.gathered(), "e"))


def outcome(finding):
    return finding.decision.outcome


@pytest.mark.parametrize(
    ("predicate", "value", "outcome", "leans"),
    [
        ("median_below", 0.95, "holds", True),
        ("median_below", 0.3, "open", True),
        ("median_below", 0.2, "open", False),
        ("median_below", 0.1, "fails", False),
        ("median_above", 0.09, "holds", True),
        ("median_above", 0.15, "open", True),
        ("median_above", 0.9, "fails", False),
    ],
)
def test_a_median_is_compared_with_its_whole_interval(store, predicate, value, outcome, leans):
    store.run("e", {"mae_H_sum": [0.1, 0.2, 0.2, 0.3, 0.9]})
    decision = judged(store, predicate, metric="mae_H_sum", value=value, where=T2).decision
    assert (decision.outcome, decision.leans) == (outcome, leans)


def test_every_setting_of_a_family_must_lie_below(store):
    store.run("e", {"passivity_margin": [-1.0, -2.0]})
    store.run("e", {"passivity_margin": [-3.0, 0.5]}, basis="t1")
    parameters = {"metric": "passivity_margin", "where": {"model": "lagrangian"}}
    finding = judged(store, "every_setting_below", value=0.6, **parameters)
    assert outcome(finding) == "holds"
    assert (finding.estimate.median, finding.estimate.n, len(finding.runs)) == (0.5, 4, 2)
    assert outcome(judged(store, "every_setting_below", value=0.0, **parameters)) == "fails"
    store.run("e", {"passivity_margin": [-1.0, math.nan]}, basis="raw")
    assert outcome(judged(store, "every_setting_below", value=0.6, **parameters)) == "fails"
    with pytest.raises(NotRunError, match="not measured"):
        judged(store, "every_setting_below", value=0.6, metric="damping_error", where={"model": "lagrangian"})


def test_every_member_must_lie_away_from_the_value(store):
    store.run("e", {"min_T": [-3.0, 0.5]})
    arguments = {"metric": "min_T", "value": 0.0, "where": T2}
    assert outcome(judged(store, "all_members_away_from", distance=0.5, **arguments)) == "holds"
    assert outcome(judged(store, "all_members_away_from", distance=0.6, **arguments)) == "fails"


def test_a_fit_fails_in_any_of_three_ways(store):
    store.run("e", {"mae_qdd": [2.0]}, model="trivial", basis="", optimiser="")
    store.run(
        "e",
        {"mae_qdd": [0.1, 0.1, 3.0, math.nan], "min_eig_M": [0.1, -0.2, 0.1, math.nan]},
        status=["ok", "ok", "ok", "diverged at step 3"],
        objective="forward",
    )
    finding = judged(store, "share_of_failures_at_least", share_of_members=0.75, where=FORWARD)
    assert finding.estimate.median == 0.75
    assert finding.decision.leans
    assert outcome(finding) == "open"
    assert "1 diverged, 1 worse than the trivial model, 1 with an indefinite mass matrix" in finding.note


@pytest.mark.parametrize(("large", "outcome"), [(0.1, "holds"), (3.0, "open")])
def test_small_networks_fail_more_often_than_large_ones(store, large, outcome):
    store.run("e", {"mae_qdd": [2.0]}, model="trivial", basis="", optimiser="")
    store.run("e", {"mae_qdd": [3.0] * 10, "min_eig_M": [0.1] * 10}, objective="forward")
    store.run("e", {"mae_qdd": [large] * 10, "min_eig_M": [0.1] * 10}, objective="forward", hidden="2x500")
    small, wide = ({**FORWARD, "hidden": hidden} for hidden in ("10", "2x500"))
    found = judged(store, "fails_more_often", where=small, against=wide)
    assert (found.decision.outcome, found.estimate.median) == (outcome, 1.0)
    most = judged(store, "share_of_failures_at_most", share_of_members=0.5, where=small)
    assert most.decision.outcome == "fails"


def test_a_run_that_died_is_no_failed_fit(store):
    store.run("e", {}, seeds=[0, 1], outcome="failed", objective="forward")
    with pytest.raises(NotRunError, match="failed: MemoryError: no room"):
        judged(store, "share_of_failures_at_least", share_of_members=1.0, where=FORWARD)


def test_pairs_are_compared_member_by_member_in_every_metric(store):
    store.run("e", {"mae_tau": [0.1, 1.0, 10.0, 1.0, 1.0], "mae_qdd": [1.0] * 5})
    store.run("e", {"mae_tau": [0.21, 2.0, 20.0, 2.0, 2.0], "mae_qdd": [1.1, 0.9, 1.0, 1.0, 1.0]}, objective="forward")
    compared = {"where": T2, "against": FORWARD}
    assert outcome(judged(store, "paired_ratio_below", metrics=["mae_tau"], **compared)) == "holds"
    both = judged(store, "paired_ratio_below", metrics=["mae_tau", "mae_qdd"], **compared)
    assert outcome(both) == "open"
    assert len(both.runs) == 2


@pytest.mark.parametrize(
    ("ratio", "below", "not_above"),
    [(0.94, "holds", "holds"), (1.0, "fails", "holds"), (1.04, "fails", "holds"), (1.06, "fails", "fails")],
)
def test_ratios_nearer_to_one_than_the_margin_count_as_equal(store, ratio, below, not_above):
    store.run("e", {"mae_tau": [ratio] * 5})
    store.run("e", {"mae_tau": [1.0] * 5}, objective="forward")
    compared = {"metrics": ["mae_tau"], "where": T2, "against": FORWARD}
    assert outcome(judged(store, "paired_ratio_below", **compared)) == below
    assert outcome(judged(store, "paired_ratio_below", allow_equal=True, **compared)) == not_above


def test_only_like_is_compared_with_like(store):
    store.run("e", {"mae_tau": [0.1, 0.1]}, epochs=5000)
    store.run("e", {"mae_tau": [0.3, 0.3]}, objective="forward", epochs=1000)
    compared = {"metrics": ["mae_tau"], "where": T2, "against": FORWARD}
    with pytest.raises(NotRunError, match=r"no like-for-like pair.*epochs \(1000, 5000\)"):
        judged(store, "paired_ratio_below", **compared)
    store.run("e", {"mae_tau": [0.2, 0.21]}, epochs=1000, as_printed=False)
    assert judged(store, "paired_ratio_below", **compared).estimate.median == pytest.approx(0.6833, abs=1e-4)


def test_a_forward_fit_that_always_fails_loses_every_pair(store):
    store.run("e", {"mae_tau": [0.1] * 5})
    store.run("e", {"mae_tau": [math.nan] * 5}, objective="forward", status=["diverged at step 1"] * 5)
    compared = {"metrics": ["mae_tau"], "where": T2, "against": FORWARD}
    assert outcome(judged(store, "paired_ratio_below", **compared)) == "holds"
    swapped = {"metrics": ["mae_tau"], "where": FORWARD, "against": T2}
    assert outcome(judged(store, "paired_ratio_below", **swapped)) == "fails"


@pytest.mark.parametrize(("ratio", "outcome"), [(2.8, "holds"), (3.0, "open"), (4.1, "fails")])
def test_unpaired_medians_may_have_unlike_budgets(store, ratio, outcome):
    store.run("e", {"mae_qdd": [6.0, 7.0, 7.0, 7.0, 8.0]}, epochs=1)
    store.run("e", {"mae_qdd": [2.0] * 5}, objective="forward", epochs=2)
    parameters = {"metric": "mae_qdd", "where": T2, "against": FORWARD}
    assert judged(store, "ratio_at_least", ratio=ratio, **parameters).decision.outcome == outcome


def test_every_problem_size_must_win_with_its_lower_quartile_and_by_the_margin(store):
    row = {"name": "forward_vs_inverse", "size": "1x10", "ratio_median": 1.2, "ratio_q25": 1.1, "ratio_q75": 1.3}
    store.bench([row, {**row, "size": "2x32", "ratio_median": 1.07, "ratio_q25": 1.02}])
    every = judged(store, "bench_ratio_above", ratio=1.0, bench={"name": "forward_vs_inverse"})
    assert outcome(every) == "open"
    assert (every.estimate.median, every.estimate.low, every.estimate.n) == (1.07, 1.02, 2)
    one = {"name": "forward_vs_inverse", "size": "1x10"}
    assert outcome(judged(store, "bench_ratio_above", ratio=1.0, bench=one)) == "holds"
    with pytest.raises(NotRunError, match="no timing with name=delan"):
        judged(store, "bench_ratio_above", ratio=1.0, bench={"name": "delan"})


def race(goal, ours, other, *ratios):
    """A row of trainings to an accuracy, reached from so many of five starts; ratios: least, quartile, median, .."""
    row = {"name": "race", "size": "1x10", "metric": "MAE_qdd", "goal": goal, "starts": 5}
    keys = ("ratio_least", "ratio_q25", "ratio_median", "ratio_q75", "ratio_greatest")
    return row | {"ours_reached": ours, "other_reached": other} | dict(zip(keys, ratios, strict=True))


NEVER, ALWAYS = (0.0,) * 5, (math.inf,) * 5


@pytest.mark.parametrize(
    ("rows", "expected", "n"),
    [
        ([race(0.1, 5, 5, 1.1, 1.2, 1.5, 2, 3)], "holds", 5),
        ([race(0.1, 5, 5, 1.02, 1.2, 1.5, 2, 3)], "open", 5),
        ([race(0.1, 5, 5, 0.5, 0.6, 0.7, 0.8, 0.9)], "fails", 5),
        ([race(0.1, 5, 0, *ALWAYS)], "holds", 5),
        ([race(0.1, 0, 5, *NEVER)], "fails", 5),
        ([race(0.1, 5, 5, 1.1, 1.2, 1.5, 2, 3), race(0.01, 5, 5, 0.5, 0.6, 0.7, 0.8, 0.9)], "open", 5),
        ([race(0.1, 5, 5, 1.1, 1.2, 1.5, 2, 3), race(0.01, 0, 2, *NEVER)], "holds", 5),
        ([race(0.1, 2, 1, 1.1, 1.2, 1.5, 2, 3)], "holds", 2),
        ([race(0.1, 0, 0, *[math.nan] * 5)], "open", 0),
    ],
)
def test_a_race_is_judged_by_its_starts_at_every_accuracy_that_enough_of_them_reach(store, rows, expected, n):
    store.bench(rows)
    finding = judged(store, "bench_ratio_above", ratio=1.0, bench={"name": "race"})
    assert (outcome(finding), finding.estimate.n) == (expected, n)
    assert all(f"MAE_qdd {row['goal']:g} " in finding.note for row in rows)
