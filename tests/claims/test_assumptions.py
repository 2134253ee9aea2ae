import pytest
import yaml

from repro.claims.assumptions import load_assumptions
from repro.errors import UserError

ROW = dict.fromkeys(("id", "where", "quote", "problem", "choice", "config", "evidence"), "x")


def write(folder, *rows):
    path = folder / "assumptions.yaml"
    path.write_text(yaml.safe_dump(list(rows)))
    return path


@pytest.mark.parametrize(
    "sensitivity",
    [[], "", [{"claims": ["C1"]}], [{"claims": "C1", "instead": ["a=b"]}], [{"claims": [1], "instead": ["a=b"]}], {}],
)
def test_a_malformed_trial_is_one_line_with_its_row_and_key(tmp_path, sensitivity):
    with pytest.raises(UserError, match=r"^assumptions.yaml, row 2 \(x\): sensitivity.*$"):
        load_assumptions(
            write(tmp_path, {**ROW, "id": "y", "sensitivity": "none"}, {**ROW, "sensitivity": sensitivity})
        )


def test_missing_and_unknown_keys_are_named(tmp_path):
    row = {**ROW, "sensitivity": "none", "quote": " "}
    row.pop("evidence")
    with pytest.raises(UserError) as caught:
        load_assumptions(write(tmp_path, row, {**ROW, "sensitivity": "none", "proof": "x"}))
    quote, evidence, unknown = str(caught.value).splitlines()
    assert "row 1 (x): quote" in quote and "row 1 (x): evidence: a value is needed" in evidence
    assert "row 2 (x): has unknown key proof" in unknown and "sensitivity" in unknown


def test_a_row_has_trials_or_the_reason_why_not(tmp_path):
    trial = {"claims": ["C4a"], "instead": ["data=long"], "both": "seeds=1"}
    rows = ({**ROW, "sensitivity": [trial]}, {**ROW, "id": "y", "config": "none", "sensitivity": " an erratum "})
    tried, untried = load_assumptions(write(tmp_path, *rows))
    assert tried.trials[0].model_dump() == {**trial, "only": ""} and tried.untried == ""
    assert untried.trials == [] and untried.untried == "an erratum"
