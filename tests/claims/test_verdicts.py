import math

import pytest
from sample_claims import PREDICATE, number, statement

from repro.claims.verdicts import counts_of_claims, headline, judge, verdict_of_number
from repro.report.tables.verdicts import cure, mark


@pytest.mark.parametrize(
    ("members", "printed", "verdict"),
    [
        ([0.2, 0.25, 0.3, 0.35, 0.4], 0.5, "consistent"),  # beyond every member, within what one more may be
        ([0.2, 0.25, 0.3, 0.35, 0.4], 0.9, "outside"),
        ([0.2, 0.25, 0.3, 0.35, 0.4], 0.1, "outside"),
        ([0.2, 0.2, 0.2, 0.2, 0.4], 0.39, "consistent"),  # among the members
        ([*[1.0] * 60, *[2.0] * 60], 2.1, "outside"),  # by rank, where there are enough
        ([0.3], 0.3, "too few"),
        ([0.3, math.nan], 0.3, "too few"),
    ],
)
def test_the_rule_for_numbers(members, printed, verdict):
    assert verdict_of_number(printed, members, log=True) == verdict


@pytest.mark.parametrize(("printed", "note"), [(1.2, "our median is better"), (0.2, "our median is worse"), (0.6, "")])
def test_the_rank_of_a_printed_number_and_the_side_of_the_median_stand_beside(store, printed, note):
    store.run("sip_basis", {"mae_tau": [0.4, 0.5, 0.6, 0.7, 0.8]})
    verdict = judge(number(printed=printed), store.gathered())
    assert f"{sum(m < printed for m in (0.4, 0.5, 0.6, 0.7, 0.8))} of 5 members below the printed value" in verdict.note
    assert ("our median" in verdict.note) == bool(note)
    assert note in verdict.note


def test_a_number_that_nearly_anything_is_consistent_with_counts_as_undecided(store):
    store.run("sip_basis", {"mae_tau": [1e-3, 1e-2, 0.1, 1.0, 10.0]})
    verdict = judge(number(), store.gathered())
    assert (verdict.verdict, verdict.counted_as) == ("consistent", "undecided")
    assert "excludes too little" in verdict.note


def test_a_number_is_judged_from_stored_runs(store):
    run = store.run("sip_basis", {"mae_tau": [0.26, 0.28, 0.30, 0.33, 0.35]})
    verdict = judge(number(), store.gathered())
    assert (verdict.verdict, verdict.estimate.median, verdict.estimate.n) == ("consistent", 0.30, 5)
    assert verdict.runs == (run,)
    assert verdict.commands[0].startswith("repro run")
    assert not verdict.preview
    assert not verdict.stale
    assert verdict.as_printed


def test_below_the_paper_scale_a_verdict_is_a_preview_and_off_its_protocol_it_is_marked(store, quick_store):
    quick_store.run("sip_basis", {"mae_tau": [0.3, 0.3]})
    assert judge(number(), quick_store.gathered()).preview
    store.count = 50
    store.run("sip_basis", {"mae_tau": [0.3, 0.3]}, as_printed=False)
    for claim in (number(), statement()):
        verdict = judge(claim, store.gathered())
        assert not verdict.as_printed
        assert "other protocol" in mark(verdict)


def test_without_runs_a_claim_is_not_run_and_says_what_was_looked_for(store):
    verdict = judge(number(), store.gathered())
    assert verdict.verdict == "not run"
    assert "no run of sip_basis with basis=t2" in verdict.note
    store.run("sip_basis", {"mae_qdd": [1.0]})
    assert "mae_tau was not measured" in judge(number(), store.gathered()).note


def test_an_ambiguous_selector_is_not_answered_but_the_literal_protocol_goes_first(store):
    store.run("sip_basis", {"mae_tau": [0.3, 0.3]}, as_printed=False, epochs=1000)
    store.run("sip_basis", {"mae_tau": [0.9, 0.9]}, as_printed=False, epochs=2000)
    verdict = judge(number(), store.gathered())
    assert verdict.verdict == "not run"
    assert "ambiguous: its settings differ in epochs (1000, 2000)" in verdict.note
    store.run("sip_basis", {"mae_tau": [0.31, 0.31]}, epochs=5000)
    assert judge(number(), store.gathered()).estimate.median == 0.31


def test_a_match_that_the_oracle_shares_says_so(store):
    store.run("sip_basis", {"onestep_euler_qd[0]": [0.28, 0.29, 0.3, 0.31, 0.32]})
    store.run(
        "sip_basis", {"onestep_euler_qd[0]": [0.29, 0.3]}, basis="t1", optimiser="least_squares", as_printed=False
    )
    verdict = judge(number(metric="onestep_euler_qd[0]"), store.gathered())
    assert (verdict.verdict, verdict.flag) == ("consistent", "also reached by: oracle 0.295")


def test_an_anchor_of_another_test_set_is_no_anchor(store):
    store.run("sip_basis", {"mae_tau": [0.01, 0.011, 0.012]})
    store.run("sip_basis", {"mae_tau": [0.1]}, model="degenerate", regime="long")
    assert judge(number(), store.gathered()).flag == ""


def test_a_declared_claim_keeps_its_declaration_and_shows_our_number(store):
    declared = number(kind="declared", declared="not comparable", reason="gauge")
    assert judge(declared, store.gathered()).verdict == "not comparable"
    store.run("sip_basis", {"mae_tau": [7.0, 8.0]})
    verdict = judge(declared, store.gathered())
    assert (verdict.verdict, verdict.estimate.median, verdict.note) == ("not comparable", 7.5, "gauge")


def test_members_that_diverged_are_counted_and_said(store):
    store.run("sip_basis", {"mae_tau": [0.3, 0.3, 5.0]}, status=["ok", "ok", "diverged at step 9"])
    verdict = judge(number(), store.gathered())
    assert (verdict.estimate.failed, verdict.estimate.n) == (1, 3)
    assert "1 of 3 members failed" in verdict.note


def test_a_stale_run_makes_a_stale_verdict(store):
    run = store.run("sip_basis", {"mae_tau": [0.3, 0.3]})
    assert judge(number(), store.gathered(stale={run})).stale


@pytest.mark.parametrize(
    ("field", "value", "verdict"),
    [
        ("with_changes", "a longer horizon", "supported with changes"),
        ("by_construction", "an identity", "true by construction"),
        ("about", "nothing of ours", "supported"),
    ],
)
def test_what_a_statement_needs_or_cannot_fail_is_another_word_when_it_holds(store, field, value, verdict):
    holds = statement(**{field: value})
    store.run("sip_basis", {"mae_tau": [0.3] * 5})
    assert judge(holds, store.gathered()).verdict == verdict
    store.count = 90
    store.run("sip_basis", {"mae_tau": [3.0] * 5}, basis="t1")
    fails = statement({**PREDICATE, "where": {"basis": "t1"}}, **{field: value})
    assert judge(fails, store.gathered()).verdict == "not supported"


def test_a_cure_is_judged_by_the_rules_of_claims_with_its_own_runs(store):
    better = {**PREDICATE, "value": 0.1, "where": {"basis": "t1"}}
    claim = statement({**PREDICATE, "value": 0.1}, cure={"change": "the basis T1", "predicate": better})
    store.run("sip_basis", {"mae_tau": [0.3] * 5})
    verdict = judge(claim, store.gathered())
    assert (verdict.verdict, cure(verdict)) == ("not supported", "the basis T1: not run")
    run = store.run("sip_basis", {"mae_tau": [0.01] * 5}, basis="t1")
    verdict = judge(claim, store.gathered())
    assert cure(verdict) == "the basis T1: 0.01 [0.01, 0.01], supported with changes"
    assert verdict.cure.runs == (run,)


def test_a_claim_counts_as_its_weakest_part(store):
    store.run("sip_basis", {"mae_tau": [0.28, 0.29, 0.3, 0.31, 0.32]})
    good, absent = number(part="a"), number(part="b", selector={"basis": "raw"})
    other = number(id="C5")
    verdicts = [judge(each, store.gathered()) for each in (good, absent, other)]
    assert counts_of_claims(verdicts) == {"not run": 1, "supported": 1}
    assert headline(verdicts) == "2 claims: 1 supported, 1 not run"
