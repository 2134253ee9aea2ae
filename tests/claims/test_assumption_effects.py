"""A claim judged again with another run in the place of its own, from stored results alone."""

from dataclasses import replace

import pandas as pd
import pytest
from synthetic_sensitivity import CLAIMS, sensitivity_runs

from repro.claims.assumption_effects import assumption_effects
from repro.results.results import Results


@pytest.fixture
def sensitivity(store):
    return sensitivity_runs(store)


def test_a_claim_finds_the_run_that_stands_in_though_its_card_is_another(sensitivity):
    number, pair, metric = assumption_effects(sensitivity, CLAIMS)
    assert (number.ours.leaning, number.other.leaning, number.moved) == ("consistent", "outside", True)
    assert (number.ours.estimate.median, number.other.estimate.median) == (0.3, 3.0)
    assert (pair.ours.leaning, pair.other.leaning, pair.moved) == ("supported", "not supported", True)
    assert pair.other.estimate.median == pytest.approx(5.0)
    assert (metric.choice, metric.other.estimate.median, metric.moved) == ("metric=mae_tau", 3.0, True)
    assert all(each.ours.preview and each.other.preview for each in (number, pair, metric))


def test_what_was_not_run_has_not_moved(sensitivity):
    case = sensitivity.cases[:1].assign(instead="sip-run-of-another-store")
    (one,) = assumption_effects(replace(sensitivity, cases=case), CLAIMS)
    assert (one.ours.leaning, one.other.verdict, one.moved) == ("consistent", "not run", None)


def test_cases_and_results_are_stored_and_read_back(sensitivity, tmp_path):
    sensitivity.save(tmp_path)
    again = Results.load(tmp_path)
    pd.testing.assert_frame_equal(again.cases, sensitivity.cases)
    assert [each.moved for each in assumption_effects(again, CLAIMS)] == [True, True, True]
