"""The ids of stages stay the same under other versions of the libraries that read settings."""

import pytest

from repro.config.compose import compose
from repro.pipeline.plan import Pipeline
from repro.tracking import code
from repro.tracking.record import Identity

CASES = {
    "closed form": ("basis=t1", "optimiser=least_squares", "system.damping=[0.1,0.02]", "energies.horizons=[1]"),
    "pretrained": ("system=dip", "basis=fxf", "sequence=pretrain", "objective.l1_kinetic=1e-5", "data=long"),
    "driven": ("model=truth", "control=sip_best", "task=random"),
}
IDS = {
    "closed form": [
        "sip-episodes1000-11bbf40718",
        "sip-lagrangian-t1-inverse-least-squares-a94ce4e4f9",
        "sip-lagrangian-t1-inverse-least-squares-bdd8ffe250",
    ],
    "pretrained": [
        "dip-long-2a077904e7",
        "dip-free-cfe7fa2133",
        "dip-lagrangian-fxf-inverse-adam-pretrain-92f672c4f0",
        "dip-lagrangian-fxf-inverse-adam-pretrain-b98e285758",
    ],
    "driven": [
        "sip-episodes1000-c8999d9489",
        "sip-truth-ca7883ddf3",
        "sip-truth-sip-best-9bfd7e0ada",
        "sip-truth-sip-best-a14b293853",
    ],
}


@pytest.mark.parametrize("case", CASES)
def test_the_ids_of_stages_follow_from_settings_alone(case, monkeypatch):
    """The part of an id that is the code is held fixed; a change of settings or of their defaults changes these ids."""
    monkeypatch.setattr(code, "closure", lambda modules: Identity())
    composed = compose((*CASES[case], "scale=smoke"))
    assert [stage.id for stage in Pipeline.of(composed.config, composed.command).stages] == IDS[case]
