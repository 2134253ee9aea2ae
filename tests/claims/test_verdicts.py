import math

import pytest

from repro.claims.claims import Claim, Tolerance
from repro.claims.verdicts import judge, verdict_of_number
from repro.results.statistics import Estimate

HALF = Tolerance(factor=1.5, reason="one run")


def claim(**changes) -> Claim:
    fields = {
        "id": "C4",
        "part": "",
        "kind": "number",
        "section": "V",
        "quote": "q",
        "about": "a",
        "experiment": "sip_basis",
        "metric": "mae_tau",
        "unit": "N",
        "printed": 0.3,
        "selector": {"basis": "t2"},
        "tolerance": HALF,
    }
    return Claim(**{**fields, **changes})


@pytest.mark.parametrize(
    ("median", "low", "high", "verdict"),
    [
        (0.45, 0.40, 0.50, "matched"),  # on the edge of the tolerance
        (0.20, 0.01, 0.02, "matched"),  # within tolerance, wherever the interval lies
        (0.46, 0.31, 0.60, "worse"),
        (0.46, 0.30, 0.60, "inconclusive"),  # the interval touches the printed value
        (0.46, 0.29, 0.60, "inconclusive"),
        (0.19, 0.10, 0.29, "better"),
        (0.19, 0.10, 0.30, "inconclusive"),
        (0.19, math.nan, math.nan, "inconclusive"),  # one member: no interval
        (math.inf, 0.1, 0.2, "worse"),  # half of the members failed
    ],
)
def test_the_rule_for_numbers_at_its_boundaries(median, low, high, verdict):
    assert verdict_of_number(Estimate(median, low, high, 5), 0.3, HALF) == verdict


def test_where_more_is_better_the_sides_change_places():
    found = Estimate(0.9, 0.85, 0.95, 5)
    assert verdict_of_number(found, 0.3, HALF, lower_is_better=False) == "better"
    assert verdict_of_number(found, 0.3, HALF) == "worse"


def test_a_setting_of_which_a_member_failed_is_never_better():
    assert verdict_of_number(Estimate(0.1, 0.05, 0.15, 5, failed=1), 0.3, HALF) == "inconclusive"


@pytest.mark.parametrize(
    ("tolerance", "around"),
    [
        (Tolerance(factor=2.0, reason="r"), (1.0, 4.0)),
        (Tolerance(relative=0.1, reason="r"), (1.8, 2.2)),
        (Tolerance(absolute=0.5, reason="r"), (1.5, 2.5)),
    ],
)
def test_the_three_tolerances(tolerance, around):
    assert tolerance.around(2.0) == pytest.approx(around)


def test_a_number_is_judged_from_stored_runs(store):
    run = store.run("sip_basis", {"mae_tau": [0.28, 0.30, 0.33]})
    verdict = judge(claim(), store.gathered())
    assert (verdict.verdict, verdict.estimate.median, verdict.estimate.n) == ("matched", 0.30, 3)
    assert verdict.runs == (run,)
    assert verdict.commands[0].startswith("repro run")
    assert not verdict.preview
    assert not verdict.stale


def test_below_the_paper_scale_and_off_its_protocol_a_verdict_is_a_preview(store, quick_store):
    quick_store.run("sip_basis", {"mae_tau": [0.3, 0.3]})
    assert judge(claim(), quick_store.gathered()).preview
    store.count = 50
    store.run("sip_basis", {"mae_tau": [0.3, 0.3]}, as_printed=False)
    verdict = judge(claim(), store.gathered())
    assert verdict.preview
    assert "not the paper's full protocol" in verdict.note


def test_without_runs_a_claim_is_not_run_and_says_what_was_looked_for(store):
    verdict = judge(claim(), store.gathered())
    assert verdict.verdict == "not run"
    assert "no run of sip_basis with basis=t2" in verdict.note
    store.run("sip_basis", {"mae_qdd": [1.0]})
    assert "mae_tau was not measured" in judge(claim(), store.gathered()).note


def test_an_ambiguous_selector_is_not_answered_but_the_literal_protocol_goes_first(store):
    store.run("sip_basis", {"mae_tau": [0.3, 0.3]}, as_printed=False, epochs=1000)
    store.run("sip_basis", {"mae_tau": [0.9, 0.9]}, as_printed=False, epochs=2000)
    verdict = judge(claim(), store.gathered())
    assert verdict.verdict == "not run"
    assert "ambiguous: its settings differ in epochs (1000, 2000)" in verdict.note
    store.run("sip_basis", {"mae_tau": [0.31, 0.31]}, epochs=5000)
    assert judge(claim(), store.gathered()).estimate.median == 0.31


def test_a_better_that_the_degenerate_model_also_reaches_is_flagged(store):
    store.run("sip_basis", {"mae_tau": [0.01, 0.011, 0.012]})
    store.anchors("sip_basis", trivial={"mae_tau": 1.4}, degenerate={"mae_tau": 0.12})
    verdict = judge(claim(), store.gathered())
    assert verdict.verdict == "better"
    assert verdict.flag == "also reached by: degenerate 0.12"


def test_a_match_that_the_oracle_shares_says_so(store):
    store.run("sip_basis", {"onestep_euler_qd[0]": [0.3, 0.31]})
    store.run(
        "sip_basis", {"onestep_euler_qd[0]": [0.29, 0.3]}, basis="t1", optimiser="least_squares", as_printed=False
    )
    verdict = judge(claim(metric="onestep_euler_qd[0]"), store.gathered())
    assert (verdict.verdict, verdict.flag) == ("matched", "also reached by: oracle 0.295")


def test_an_anchor_of_another_test_set_is_no_anchor(store):
    store.run("sip_basis", {"mae_tau": [0.01, 0.011, 0.012]})
    store.run("sip_basis", {"mae_tau": [0.1]}, model="degenerate", regime="long")
    assert judge(claim(), store.gathered()).flag == ""


def test_a_declared_claim_keeps_its_declaration_and_shows_our_number(store):
    declared = claim(kind="declared", tolerance=None, declared="not comparable", reason="gauge")
    assert judge(declared, store.gathered()).verdict == "not comparable"
    store.run("sip_basis", {"mae_tau": [7.0, 8.0]})
    verdict = judge(declared, store.gathered())
    assert (verdict.verdict, verdict.estimate.median, verdict.note) == ("not comparable", 7.5, "gauge")


def test_members_that_diverged_are_counted_and_said(store):
    store.run("sip_basis", {"mae_tau": [0.3, 0.3, 5.0]}, status=["ok", "ok", "diverged at step 9"])
    verdict = judge(claim(), store.gathered())
    assert (verdict.estimate.failed, verdict.estimate.n) == (1, 3)
    assert "1 of 3 members failed" in verdict.note


def test_a_stale_run_makes_a_stale_verdict(store):
    run = store.run("sip_basis", {"mae_tau": [0.3, 0.3]})
    assert judge(claim(), store.gathered(stale={run})).stale
