from pathlib import Path

import pytest
import yaml

from repro.claims.claims import load_claims
from repro.errors import UserError
from repro.tracking.paths import project_folder

NUMBER = {
    "id": "C1",
    "kind": "number",
    "section": "V",
    "quote": "q",
    "about": "a",
    "experiment": "sip_basis",
    "metric": "mae_tau",
    "unit": "N",
    "printed": 0.26,
    "selector": {"basis": "t2"},
    "tolerance": {"factor": 1.5, "reason": "one run"},
}
STATEMENT = {
    "id": "C2",
    "kind": "statement",
    "section": "V",
    "quote": "q",
    "about": "a",
    "experiment": "sip_basis",
    "predicate": {"name": "median_below", "metric": "mae_tau", "value": 1.0, "where": {"basis": "t2"}},
}
PREDICATE = STATEMENT["predicate"]


def write(folder: Path, *rows) -> Path:
    path = folder / "claims.yaml"
    path.write_text(yaml.safe_dump(list(rows)), encoding="utf-8")
    return path


def test_the_projects_claims_are_complete_and_well_formed():
    claims = load_claims(project_folder() / "paper" / "claims.yaml")
    assert {claim.id for claim in claims} == {f"C{number}" for number in range(1, 25)}
    assert all(
        claim.tolerance is None or len(claim.tolerance.reason) > 20 or "C1a" in claim.tolerance.reason
        for claim in claims
    )


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({**NUMBER, "kind": "guess"}, "kind is 'guess'; allowed: number, statement, declared"),
        ({k: v for k, v in NUMBER.items() if k != "quote"}, "needs quote"),
        ({**NUMBER, "verdict": "matched"}, "verdict is not a field .*verdicts are computed"),
        ({**NUMBER, "printed": "5e-4"}, "printed is '5e-4', not a number"),
        ({**NUMBER, "selector": {"bases": "t2"}}, "bases is not a card column; allowed: system"),
        ({**NUMBER, "tolerance": {"factor": 1.5}}, "a tolerance has one of factor, relative, absolute and a reason"),
        ({**NUMBER, "tolerance": {"factor": 1.0, "reason": "r"}}, "leaves no room"),
        (
            {**STATEMENT, "predicate": {"name": "looks_fine"}},
            "no predicate is called 'looks_fine'; allowed: ",
        ),
        ({**STATEMENT, "predicate": {"name": "median_below", "metric": "m"}}, "median_below needs value, where"),
        ({**STATEMENT, "predicate": {**PREDICATE, "valu": 1}}, "does not know valu"),
        ({**STATEMENT, "predicate": {**PREDICATE, "value": "low"}}, "value must be a number, not 'low'"),
        ({**STATEMENT, "predicate": {**PREDICATE, "where": {"bases": 1}}}, "where names bases; allowed: system"),
        ({**NUMBER, "kind": "declared", "declared": "unclear", "reason": "r", "tolerance": None}, "tolerance is not a"),
    ],
)
def test_a_faulty_claim_is_one_clear_error(tmp_path, row, message):
    with pytest.raises(UserError, match=message):
        load_claims(write(tmp_path, row))


def test_an_unknown_declaration_is_an_error(tmp_path):
    row = {k: v for k, v in NUMBER.items() if k != "tolerance"}
    with pytest.raises(UserError, match="declared is 'unclear'; allowed: not comparable, under-specified"):
        load_claims(write(tmp_path, {**row, "kind": "declared", "declared": "unclear", "reason": "r"}))


def test_two_rows_of_one_name_are_an_error(tmp_path):
    with pytest.raises(UserError, match="C1 stands there twice"):
        load_claims(write(tmp_path, NUMBER, NUMBER))
    assert [claim.name for claim in load_claims(write(tmp_path, NUMBER, {**NUMBER, "part": "b"}))] == ["C1", "C1b"]


def test_a_file_that_is_no_list_is_an_error(tmp_path):
    path = tmp_path / "claims.yaml"
    path.write_text("a: [", encoding="utf-8")
    with pytest.raises(UserError, match="cannot be read"):
        load_claims(path)
    path.write_text("a: 1", encoding="utf-8")
    with pytest.raises(UserError, match="must be a list"):
        load_claims(path)
