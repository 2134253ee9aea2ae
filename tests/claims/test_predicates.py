import math

import pytest
from pydantic import TypeAdapter

from repro.claims.evidence import Evidence
from repro.claims.predicate import Predicate
from repro.results.selectors import NotRunError

T2 = {"basis": "t2", "objective": "inverse"}
FORWARD = {"basis": "t2", "objective": "forward"}


def judged(store, name, **parameters):
    predicate = TypeAdapter(Predicate).validate_python({"name": name, **parameters})
    return predicate.judge(Evidence(store.gathered(), "e"))


def test_medians_are_compared_strictly(store):
    store.run("e", {"mae_H_sum": [0.1, 0.2, 0.9]})
    for predicate, value, holds in (
        ("median_below", 0.2, False),
        ("median_below", 0.21, True),
        ("median_above", 0.2, False),
        ("median_above", 0.19, True),
    ):
        assert judged(store, predicate, metric="mae_H_sum", value=value, where=T2).holds is holds


def test_every_setting_of_a_family_must_lie_below(store):
    store.run("e", {"passivity_margin": [-1.0, -2.0]})
    store.run("e", {"passivity_margin": [-3.0, 0.5]}, basis="t1")
    parameters = {"metric": "passivity_margin", "where": {"model": "lagrangian"}}
    finding = judged(store, "every_setting_below", value=0.6, **parameters)
    assert finding.holds
    assert (finding.estimate.median, finding.estimate.n, len(finding.runs)) == (0.5, 4, 2)
    assert not judged(store, "every_setting_below", value=0.0, **parameters).holds
    store.run("e", {"passivity_margin": [-1.0, math.nan]}, basis="raw")
    assert not judged(store, "every_setting_below", value=0.6, **parameters).holds
    with pytest.raises(NotRunError, match="not measured"):
        judged(store, "every_setting_below", value=0.6, metric="damping_error", where={"model": "lagrangian"})


def test_every_member_must_lie_away_from_the_value(store):
    store.run("e", {"min_T": [-3.0, 0.5]})
    arguments = {"metric": "min_T", "value": 0.0, "where": T2}
    assert judged(store, "all_members_away_from", distance=0.5, **arguments).holds
    assert not judged(store, "all_members_away_from", distance=0.6, **arguments).holds


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
    assert finding.holds
    assert "1 diverged, 1 worse than the trivial model, 1 with an indefinite mass matrix" in finding.note


def test_a_run_that_died_is_no_failed_fit(store):
    store.run("e", {}, seeds=[0, 1], outcome="failed", objective="forward")
    with pytest.raises(NotRunError, match="failed: MemoryError: no room"):
        judged(store, "share_of_failures_at_least", share_of_members=1.0, where=FORWARD)


def test_pairs_are_compared_member_by_member_in_every_metric(store):
    store.run("e", {"mae_tau": [0.1, 1.0, 10.0], "mae_qdd": [1.0, 1.0, 1.0]})
    store.run("e", {"mae_tau": [0.21, 2.0, 20.0], "mae_qdd": [1.1, 0.9, 1.0]}, objective="forward")
    compared = {"where": T2, "against": FORWARD}
    assert judged(store, "paired_ratio_below", metrics=["mae_tau"], **compared).holds
    both = judged(store, "paired_ratio_below", metrics=["mae_tau", "mae_qdd"], **compared)
    assert not both.holds
    assert len(both.runs) == 2


def test_only_like_is_compared_with_like(store):
    store.run("e", {"mae_tau": [0.1, 0.1]}, epochs=5000)
    store.run("e", {"mae_tau": [0.3, 0.3]}, objective="forward", epochs=1000)
    compared = {"metrics": ["mae_tau"], "where": T2, "against": FORWARD}
    with pytest.raises(NotRunError, match=r"no like-for-like pair.*epochs \(1000, 5000\)"):
        judged(store, "paired_ratio_below", **compared)
    store.run("e", {"mae_tau": [0.2, 0.21]}, epochs=1000, as_printed=False)
    assert judged(store, "paired_ratio_below", **compared).estimate.median == pytest.approx(0.6833, abs=1e-4)


def test_a_forward_fit_that_always_fails_loses_every_pair(store):
    store.run("e", {"mae_tau": [0.1, 0.1]})
    store.run("e", {"mae_tau": [math.nan] * 2}, objective="forward", status=["diverged at step 1"] * 2)
    compared = {"metrics": ["mae_tau"], "where": T2, "against": FORWARD}
    assert judged(store, "paired_ratio_below", **compared).holds
    swapped = {"metrics": ["mae_tau"], "where": FORWARD, "against": T2}
    assert not judged(store, "paired_ratio_below", **swapped).holds


def test_unpaired_medians_may_have_unlike_budgets(store):
    store.run("e", {"mae_qdd": [6.0, 8.0]}, epochs=1)
    store.run("e", {"mae_qdd": [2.0, 2.0]}, objective="forward", epochs=2)
    parameters = {"metric": "mae_qdd", "where": T2, "against": FORWARD}
    assert judged(store, "ratio_at_least", ratio=3.5, **parameters).holds
    assert not judged(store, "ratio_at_least", ratio=3.6, **parameters).holds


def test_every_timing_must_win_with_its_lower_quartile(store):
    row = {"name": "forward_vs_inverse", "size": "1x10", "ratio_median": 1.2, "ratio_q25": 1.1, "ratio_q75": 1.3}
    store.bench([row, {**row, "size": "2x32", "ratio_median": 1.05, "ratio_q25": 0.99}])
    every = judged(store, "bench_ratio_above", ratio=1.0, bench={"name": "forward_vs_inverse"})
    assert not every.holds
    assert every.estimate.median == 1.05
    assert judged(store, "bench_ratio_above", ratio=1.0, bench={"name": "forward_vs_inverse", "size": "1x10"}).holds
    with pytest.raises(NotRunError, match="no timing with name=delan"):
        judged(store, "bench_ratio_above", ratio=1.0, bench={"name": "delan"})
