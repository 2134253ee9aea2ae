"""What the smallest scale runs of the experiments."""

from pathlib import Path

from repro.claims.claims import load_claims
from repro.config.overrides import expand
from repro.sweep import planned_job
from repro.tracking.paths import Paths

PAPER = Path(__file__).parents[2] / "paper"


def test_every_option_is_tried_once_and_every_selector_of_a_claim_has_a_run(tmp_path, monkeypatch):
    names = {"smoke": ["sip_selection"], "paper": ["sip_selection", "sip_control"]}
    monkeypatch.setattr(planned_job, "experiments", names.__getitem__)
    claims = load_claims(PAPER / "claims.yaml")
    jobs = planned_job.plan_sample(claims, Paths(tmp_path), lambda jobs: None)
    listed = [job for job in jobs if job.composed.config.experiment == "sip_selection"]
    lines = expand(["experiment=sip_selection", "scale=smoke"], first_of_line=True)
    tried = {override for job in listed for override in job.composed.overrides}
    assert tried >= {override for line in lines for override in line}
    assert len(listed) < len(expand(["experiment=sip_selection", "scale=smoke"]))
    for claim in claims:
        if claim.experiment == "sip_selection":
            assert all(any(job.agrees(where) for job in listed) for where in claim.selectors)
    assert len(jobs) - len(listed) == planned_job.BRIEFLY
