from pathlib import Path

import pytest
import yaml
from sample_claims import NUMBER, PREDICATE, STATEMENT

from repro.claims.claims import load_claims
from repro.errors import UserError
from repro.tracking.paths import project_folder

DECLARED = NUMBER | {"id": "C3", "kind": "declared", "declared": "not comparable", "reason": "r"}


def write(folder: Path, *rows) -> Path:
    path = folder / "claims.yaml"
    path.write_text(yaml.safe_dump(list(rows)), encoding="utf-8")
    return path


def test_the_projects_claims_are_complete_and_well_formed():
    claims = load_claims(project_folder() / "paper" / "claims.yaml")
    assert {claim.id for claim in claims} == {f"C{number}" for number in range(1, 29)}


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({**NUMBER, "kind": "guess"}, "kind = 'guess': .*'number', 'statement' or 'declared'"),
        ({k: v for k, v in NUMBER.items() if k != "quote"}, "quote: a value is needed"),
        ({k: v for k, v in NUMBER.items() if k != "metric"}, "a number claim needs metric"),
        ({**NUMBER, "declared": "not comparable"}, "a number claim has no declared"),
        ({**NUMBER, "verdict": "matched"}, "has unknown key verdict; allowed are id, part, kind"),
        ({**NUMBER, "printed": "5e-4"}, "printed = '5e-4': should be a number"),
        ({**NUMBER, "printed": True}, "printed = True: should be a number"),
        ({**NUMBER, "selector": {"bases": "t2"}}, "selector: has no column bases; allowed are system"),
        ({**NUMBER, "selector": "t2"}, "selector = 't2': should be a valid dictionary"),
        ({**NUMBER, "with_changes": "ours"}, "with_changes and by_construction belong to a statement"),
        ({**NUMBER, "history": [{"commit": "HEAD", "change": "c", "reason": "r"}]}, "history.0.commit = 'HEAD'"),
        (
            {**STATEMENT, "predicate": {"name": "looks_fine"}},
            "predicate.name = 'looks_fine': allowed are .*loops_su",
        ),
        ({**STATEMENT, "predicate": "median_below"}, "predicate = 'median_below': should be a valid dictionary"),
        (
            {**STATEMENT, "predicate": {k: v for k, v in PREDICATE.items() if k != "value"}},
            "predicate.value: a value is needed",
        ),
        ({**STATEMENT, "predicate": {**PREDICATE, "valu": 1}}, "predicate: has unknown key valu; allowed are .*value"),
        ({**STATEMENT, "predicate": {**PREDICATE, "value": "low"}}, "predicate.value = 'low': should be a number"),
        ({**STATEMENT, "predicate": {**PREDICATE, "where": {"bases": 1}}}, "predicate.where: has no column bases"),
        ({**DECLARED, "predicate": PREDICATE}, "a declared claim has no predicate"),
        ({**DECLARED, "declared": "unclear"}, "declared = 'unclear': .*'under-specified' or 'uninformative'"),
        ("C1", "= 'C1': should be a valid dictionary"),
    ],
)
def test_a_malformed_claim_is_one_line_with_its_row_and_key(tmp_path, row, message):
    with pytest.raises(UserError, match=rf"^claims.yaml, row 1 \((C\d|\?)\): .*{message}.*$"):
        load_claims(write(tmp_path, row))


def test_every_mistake_of_the_file_has_a_line(tmp_path):
    with pytest.raises(UserError) as caught:
        load_claims(write(tmp_path, {**NUMBER, "quote": "", "printed": "x"}, STATEMENT, {**DECLARED, "unit": 1}))
    assert [line.partition(" = ")[0] for line in str(caught.value).splitlines()] == [
        "claims.yaml, row 1 (C4): quote",
        "claims.yaml, row 1 (C4): printed",
        "claims.yaml, row 3 (C3): unit",
    ]


def test_two_rows_of_one_name_are_an_error(tmp_path):
    with pytest.raises(UserError, match=r"^claims.yaml: C4 occurs twice"):
        load_claims(write(tmp_path, NUMBER, NUMBER))
    assert [claim.name for claim in load_claims(write(tmp_path, NUMBER, {**NUMBER, "part": "b"}))] == ["C4", "C4b"]


def test_a_file_that_is_no_list_is_an_error(tmp_path):
    path = tmp_path / "claims.yaml"
    path.write_text("a: [", encoding="utf-8")
    with pytest.raises(UserError, match="cannot be read"):
        load_claims(path)
    path.write_text("a: 1", encoding="utf-8")
    with pytest.raises(UserError, match="must be a list"):
        load_claims(path)
