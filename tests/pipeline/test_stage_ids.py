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
        "sip-episodes1000-8ac0b373da",
        "sip-lagrangian-t1-inverse-least-squares-461f9cbb50",
        "sip-lagrangian-t1-inverse-least-squares-60dc4174b2",
    ],
    "pretrained": [
        "dip-long-1f16de6111",
        "dip-free-09b7d23214",
        "dip-lagrangian-fxf-inverse-adam-pretrain-d5a09ce827",
        "dip-lagrangian-fxf-inverse-adam-pretrain-f1ffb1c7e3",
    ],
    "driven": [
        "sip-episodes1000-1610a00873",
        "sip-truth-fdaae1dd11",
        "sip-truth-sip-best-63027b07b4",
        "sip-truth-sip-best-5b24e9d0a7",
    ],
}


@pytest.mark.parametrize("case", CASES)
def test_the_ids_of_stages_follow_from_settings_alone(case, monkeypatch):
    """The part of an id that is the code is held fixed; a change of settings or of their defaults changes these ids."""
    monkeypatch.setattr(code, "closure", lambda modules: Identity())
    composed = compose((*CASES[case], "scale=smoke"))
    assert [stage.id for stage in Pipeline.of(composed.config, composed.command).stages] == IDS[case]
