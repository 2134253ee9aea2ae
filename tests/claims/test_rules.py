"""The rules that decide verdicts, each on the sample for which a simpler rule gives a wrong answer.

Every case computes the simpler rule's answer beside the project's, and the two differ.
"""

import math

import numpy as np
import pytest
from pydantic import TypeAdapter
from sample_claims import number, statement
from synthetic_loops import EXPERIMENT, loop, results

from repro.claims.claims import Predicate
from repro.claims.evidence import Evidence
from repro.claims.verdicts import judge, verdict_of_number
from repro.results.selectors import AmbiguousError
from repro.results.statistics import median_interval, wilson_interval


def geometric_t_interval(values):
    """Student's t on the logarithms: the interval of the geometric mean, of log-normal members."""
    from scipy.stats import t

    logs = np.log(values)
    half = t.ppf(0.975, logs.size - 1) * logs.std(ddof=1) / math.sqrt(logs.size)
    return math.exp(logs.mean() - half), math.exp(logs.mean() + half)


def test_the_median_of_a_bimodal_sample_lies_in_its_interval():
    # Nine of 40 fits converge; the rest end about 5, as forward fits on T1/V1 do.
    members = np.concatenate([np.geomspace(1e-6, 1e-3, 9), np.geomspace(4.0, 8.0, 31)])
    low, high = geometric_t_interval(members)
    assert not low <= np.median(members) <= high
    low, high = median_interval(members)
    assert 4.0 < low < np.median(members) < high < 8.0
    assert verdict_of_number(0.42, members, log=True) == "consistent"
    assert verdict_of_number(9.0, members, log=True) == "outside"


def test_a_threshold_inside_the_interval_decides_nothing(store):
    members = [0.05, 0.06, 0.08, 0.2, 0.9]
    store.run("sip_basis", {"mae_H_sum": members})
    verdict = judge(
        statement({"name": "median_below", "metric": "mae_H_sum", "value": 0.1, "where": {"basis": "t2"}}),
        store.gathered(),
    )
    assert np.median(members) < 0.1
    assert (verdict.verdict, verdict.leaning) == ("undecided", "supported")


def test_two_members_are_too_few(store):
    store.run("sip_basis", {"mae_tau": [0.29, 0.31], "mae_H_sum": [0.01, 0.01]})
    exact = {"name": "median_below", "metric": "mae_H_sum", "value": 0.1, "where": {"basis": "t2"}}
    assert [judge(each, store.gathered()).verdict for each in (number(), statement(exact))] == ["too few", "too few"]


def test_settings_that_differ_in_what_matters_are_not_pooled():
    loops = [loop(k, False, intervals=11, horizon_s=0.44) for k in range(5)]
    loops += [loop(k, True, intervals=31, horizon_s=1.24, run="run-2") for k in range(5)]
    stored = results(loops)
    printed = {"name": "loops_succeed", "share_of_loops": 0.9, "loops": {"setting": "sip"}}
    assert sum(each["success"] for each in loops) / len(loops) == 0.5  # of no setting
    with pytest.raises(AmbiguousError, match=r"differ in intervals \(11, 31\); horizon_s \(0.44, 1.24\)"):
        judged(stored, printed)
    one = {**printed, "loops": {"setting": "sip", "intervals": 11}}
    assert judged(stored, one).estimate.median == 0.0


def test_loops_of_one_model_are_one_unit():
    loops = [loop(k, k < 19, model="lagrangian", member=k // 4) for k in range(20)]
    finding = judged(results(loops), {"name": "loops_succeed", "share_of_loops": 0.7, "loops": {"setting": "sip"}})
    assert wilson_interval(19, 20)[0] > 0.7  # as if every loop were drawn by itself
    assert (finding.estimate.n, finding.estimate.median) == (5, 0.95)
    assert finding.decision.outcome == "open"
    starts = [loop(k, k < 19) for k in range(20)]
    finding = judged(results(starts), {"name": "loops_succeed", "share_of_loops": 0.7, "loops": {"setting": "sip"}})
    assert (finding.estimate.n, finding.decision.outcome) == (20, "holds")


@pytest.mark.parametrize(("degenerate", "flag"), [(40.7, ""), (12.0, "also reached by: degenerate 12")])
def test_an_anchor_is_named_only_where_it_satisfies_the_verdict(store, degenerate, flag):
    # Within a factor of five of the printed 12.35 lies 40.7 as well: a tolerance band would name it.
    store.run("sip_basis", {"mae_tau": [8.0, 9.0, 10.0, 11.0, 12.0]})
    store.anchors("sip_basis", trivial={"mae_tau": 100.0}, degenerate={"mae_tau": degenerate})
    assert 12.35 / 5 < degenerate < 12.35 * 5
    verdict = judge(number(printed=12.35), store.gathered())
    assert (verdict.verdict, verdict.flag) == ("consistent", flag)


@pytest.mark.parametrize(
    ("successes", "verdict"),
    [((40, 40), "supported"), ((0, 0), "not supported"), ((0, 40), "under-specified"), ((40, None), "undecided")],
)
def test_readings_have_to_agree_and_all_have_to_be_run(successes, verdict):
    loops = [
        loop(k, k < share, horizon_s=horizon, run=f"run-{horizon}")
        for share, horizon in zip(successes, (0.4, 0.8), strict=True)
        if share is not None
        for k in range(40)
    ]
    predicate = {
        "name": "loops_succeed",
        "share_of_loops": 0.9,
        "loops": {"setting": "sip"},
        "readings": {"horizon_s": [0.4, 0.8]},
    }
    found = judge(statement(predicate, experiment=EXPERIMENT), results(loops))
    assert found.verdict == verdict
    assert "horizon_s=0.4: " in found.note
    assert ("horizon_s=0.8: not run" in found.note) == (successes[1] is None)


def judged(stored, parameters):
    return TypeAdapter(Predicate).validate_python(parameters).judge(Evidence(stored, EXPERIMENT))
