"""The ledger of assumptions against the project: its settings exist, its trials compose and reach their claims."""

import json
import re

import pytest

from repro import __main__ as cli
from repro.claims.assumptions import Trial, load_assumptions
from repro.claims.claims import load_claims
from repro.config.overrides import check, experiments
from repro.config.registry import groups, settings
from repro.errors import UserError
from repro.sweep import assumption_runs as sensitivity
from repro.sweep.assumption_runs import plan_cases
from repro.tracking.paths import Paths, project_folder
from repro.tracking.plain_data import flattened

PAPER = project_folder() / "paper"
LEDGER = {row.id: row for row in load_assumptions(PAPER / "assumptions.yaml")}
CLAIMS = load_claims(PAPER / "claims.yaml")
TIMING = "timing"  # the experiment of the benchmark, which has no settings


def check_key(override):
    """UserError for an unknown group or option; a key of a group must be there in one of its options."""
    check([override])
    key = override.partition("=")[0]
    group, _, leaf = key.partition(".")
    if leaf:
        assert any(leaf in flattened(settings(group, option)) for option in groups()[group]), key


@pytest.mark.parametrize("row", LEDGER.values(), ids=LEDGER)
def test_every_setting_that_an_assumption_names_exists(row):
    named = [] if row.config.startswith("none") else row.config.split(",")
    for setting in map(str.strip, named):
        key, *options = re.split(r"\s*[=|]\s*", setting)
        for option in options or ["1"]:
            try:
                check_key(f"{key}={option}")
            except UserError as error:  # a group alone names all of its options
                assert not options and "allowed are" in str(error) and "unknown" not in str(error), error


@pytest.mark.parametrize("row", LEDGER.values(), ids=LEDGER)
def test_every_assumption_is_tried_or_says_why_not(row):
    names = {claim.name for claim in CLAIMS}
    assert bool(row.trials) != bool(row.untried)
    for trial in row.trials:
        assert set(trial.claims) <= names
        for overrides in (*trial.instead, trial.both, trial.only):
            for override in overrides.split():
                if not override.startswith("metric="):
                    check_key(override)


def test_every_claim_names_an_experiment():
    assert {claim.experiment for claim in CLAIMS} <= {*experiments(), TIMING}


def plan(claims, instead, folder):
    row = LEDGER["gravity"].model_copy(update={"sensitivity": [Trial(claims=claims, instead=instead)]})
    return plan_cases([row], CLAIMS, Paths(folder))


def test_a_case_pairs_the_run_of_a_claim_with_one_that_differs_in_the_alternative(tmp_path):
    (case,), jobs = plan(["C17a"], ["system.g=9.80665"], tmp_path)
    assert (case.choice, case.alternative) == ("system.g=9.8", "system.g=9.80665")
    ours, other = ({job.run: job.pipeline.config for job in jobs}[run] for run in (case.run, case.instead))
    assert ours.scale.name == "quick"
    assert ours.members == [0, 1, 2]
    assert (ours.objective.momentum_weight, list(ours.model.momentum_hidden)) == (1.0, [8])  # as C17a selects
    assert ours.model_copy(update={"system": other.system}) == other
    assert (ours.system.g, other.system.g) == (9.8, 9.80665)


def test_a_trial_that_changes_nothing_or_names_no_claim_is_refused(tmp_path):
    with pytest.raises(UserError, match=r"gravity: system.g=9.8 changes no run that answers C17a"):
        plan(["C17a"], ["system.g=9.8"], tmp_path)
    with pytest.raises(UserError, match="no claim is called C99"):
        plan(["C99"], ["system.g=1.0"], tmp_path)


def test_unknown_assumptions_are_refused(capsys):
    assert cli.main(["sensitivity", "gravitas"]) == 2
    assert "no assumption is called gravitas; there are angle_convention" in capsys.readouterr().err


@pytest.mark.slow
def test_assumptions_are_run_listed_and_compared_and_kept_beside_others(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))
    monkeypatch.setattr(sensitivity, "SCALE", "smoke")
    monkeypatch.setattr(sensitivity, "MEMBERS", 2)
    assert cli.main(["sensitivity", "gravity", "--workers", "1"]) == 0
    assert "of 1 assumptions move an answer" in capsys.readouterr().out
    assert cli.main(["sensitivity", "data_start", "--workers", "1"]) == 0
    listed = [json.loads(path.read_text()) for path in (tmp_path / "experiments" / "sensitivity").glob("*.json")]
    assert {case["assumption"] for each in listed for case in each["cases"]} == {"gravity", "data_start"}
    made = {path.parent.name for path in tmp_path.glob("runs/*/run.json")}
    assert {run for each in listed for case in each["cases"] for run in (case["run"], case["instead"])} == made
    assert cli.main(["sensitivity", "gravity", "data_start", "--dry-run"]) == 0
    assert "0 to run" in capsys.readouterr().out


@pytest.mark.slow
def test_every_trial_of_every_assumption_composes(tmp_path):
    cases, _ = plan_cases([*LEDGER.values()], CLAIMS, Paths(tmp_path))
    assert {case.assumption for case in cases} == {row.id for row in LEDGER.values() if row.trials}
