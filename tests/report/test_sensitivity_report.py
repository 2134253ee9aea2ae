"""A claim judged again with another run in the place of its own, from stored results alone."""

import json
from dataclasses import asdict, replace

import pytest

from repro.claims.assumption_effects import comparisons, gather_sensitivity
from repro.claims.assumptions import Assumption, Trial, load_assumptions
from repro.claims.claims import Claim, Tolerance
from repro.report.tables.drift import table_drift
from repro.report.tables.sensitivity import sensitivity_table
from repro.report.terminal import show_sensitivity
from repro.results.results import SENSITIVITY, Case, Sensitivity
from repro.results.stored import stored_runs

NUMBER = Claim(
    *("C4", "a", "number", "V", "q", "about"),
    experiment="sip_basis",
    metric="mae_tau",
    unit="N",
    printed=0.3,
    selector={"basis": "t2", "regime": "episodes"},
    tolerance=Tolerance("factor", 1.5, "one run"),
)
PAIR = Claim(
    *("C14", "a", "statement", "V", "q", "about"),
    experiment="sip_basis",
    predicate={
        "name": "paired_ratio_below",
        "metrics": ["mae_tau"],
        "where": {"objective": "inverse"},
        "against": {"objective": "forward"},
    },
)


def assumption(name, **fields):
    texts = dict.fromkeys(("where", "quote", "problem", "choice", "config", "evidence"), "text")
    return Assumption(id=name, **texts, **{"trials": (), "untried": "", **fields})


LEDGER = [
    assumption("data_regime", trials=(Trial(("C4a", "C14a"), ("data=long",)),)),
    assumption("momentum", untried="an erratum"),
]


@pytest.fixture
def sensitivity(store):
    """Our choice answers C4a and C14a well; on one long run the force error is ten times as large."""
    store.scale = SENSITIVITY
    ours = store.run("sip_basis", {"mae_tau": [0.25, 0.3, 0.35], "mae_qdd": [3.0, 3.0, 3.0]})
    forward = store.run("sip_basis", {"mae_tau": [0.5, 0.7, 0.8]}, objective="forward")
    long = store.run("sip_basis", {"mae_tau": [2.5, 3.0, 3.5]}, regime="long")
    long_forward = store.run("sip_basis", {"mae_tau": [0.5, 0.6, 0.7]}, regime="long", objective="forward")
    choice = ("data_regime", "data=episodes", "data=long")
    metric = Case("metric_average", "", "metric=mae_qdd", "C4a", "sip_basis", ours, ours)
    cases = [
        Case(*choice, "C4a", "sip_basis", ours, long),
        Case(*choice, "C14a", "sip_basis", ours, long),
        Case(*choice, "C14a", "sip_basis", forward, long_forward),
        metric,
    ]
    path = store.outputs / "experiments" / SENSITIVITY / "sip_basis.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"cases": [asdict(case) for case in cases]}))
    found = gather_sensitivity([path], stored_runs(store.outputs, SENSITIVITY))
    return found, [replace(NUMBER, selector={**NUMBER.selector, "objective": "inverse"}), PAIR]


def test_a_claim_finds_the_run_that_stands_in_though_its_card_is_another(sensitivity):
    number, pair, metric = comparisons(*sensitivity)
    assert (number.ours.verdict, number.other.verdict, number.moved) == ("matched", "worse", True)
    assert (number.ours.estimate.median, number.other.estimate.median) == (0.3, 3.0)
    assert (pair.ours.verdict, pair.other.verdict, pair.moved) == ("matched", "not reproduced", True)
    assert pair.other.estimate.median == pytest.approx(5.0)
    assert (metric.choice, metric.other.estimate.median, metric.moved) == ("metric=mae_tau", 3.0, True)
    assert all(each.ours.preview and each.other.preview for each in (number, pair, metric))


def test_what_was_not_run_has_not_moved(sensitivity):
    found, claims = sensitivity
    case = replace(found.cases[0], instead="sip-run-of-another-store")
    (one,) = comparisons(replace(found, cases=(case,)), claims)
    assert (one.ours.verdict, one.other.verdict, one.moved) == ("matched", "not run", None)


def test_cases_and_results_are_stored_and_read_back(sensitivity, tmp_path):
    found, claims = sensitivity
    found.save(tmp_path)
    again = Sensitivity.load(tmp_path)
    assert again.cases == found.cases
    assert [each.moved for each in comparisons(again, claims)] == [True, True, True]
    assert Sensitivity.load(tmp_path / "elsewhere") is None


def test_the_table_has_every_assumption_and_its_drift_is_seen(sensitivity, tmp_path):
    found, claims = sensitivity
    table = sensitivity_table(LEDGER, comparisons(found, claims))
    assert [row.cells[0] for row in table.rows] == ["data_regime", "data_regime", "momentum"]
    assert table.rows[0].cells[7:] == ("matched → worse", "moved")
    assert "an erratum" in table.rows[2].cells
    table.save(tmp_path)
    committed, key = tmp_path / "sensitivity.csv", ("assumption", "alternative", "claim")
    assert table_drift(committed, table, key) == []
    text = committed.read_text()
    committed.write_text(text.replace(",0.3,0.3,", ",0.3,0.3000000000001,", 1))
    assert table_drift(committed, table, key) == []
    committed.write_text(text.replace(",worse,", ",matched,", 1))
    assert table_drift(committed, table, key) == [
        "sensitivity.csv holds another instead_verdict of data_regime data=long C4a than worse"
    ]
    committed.write_text(text.splitlines()[0])
    assert len(table_drift(committed, table, key)) == 3


def test_the_terminal_marks_what_moves_and_fits_its_width(sensitivity, capsys):
    from rich.console import Console

    for width in (80, 140):
        show_sensitivity(comparisons(*sensitivity), Console(width=width))
        text = capsys.readouterr().out
        assert all(len(line) <= width for line in text.splitlines())
        assert "matched → worse" in text
        assert "2 of 2 assumptions move a verdict" in text


@pytest.mark.parametrize(
    "sensitivity",
    [[], [{"claims": ["C1"]}], [{"claims": "C1", "instead": ["a=b"]}], [{"claims": [1], "instead": ["a=b"]}], {}],
)
def test_a_malformed_trial_is_named(tmp_path, sensitivity):
    import yaml

    from repro.errors import UserError

    path = tmp_path / "assumptions.yaml"
    row = dict.fromkeys(("id", "where", "quote", "problem", "choice", "config", "evidence"), "x")
    path.write_text(yaml.safe_dump([row | {"sensitivity": sensitivity}]))
    with pytest.raises(UserError, match=r"assumptions.yaml, (row 1|x)"):
        load_assumptions(path)
