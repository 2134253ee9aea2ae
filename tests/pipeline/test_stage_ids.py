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
        "sip-episodes1000-f158d6e121",
        "sip-lagrangian-t1-inverse-least-squares-e36e4e977d",
        "sip-lagrangian-t1-inverse-least-squares-29c7f934c8",
    ],
    "pretrained": [
        "dip-long-5c2563e426",
        "dip-free-cfe7fa2133",
        "dip-lagrangian-fxf-inverse-adam-d-h-418fe1fa00",
        "dip-lagrangian-fxf-inverse-adam-pretrain-d3912782ac",
        "dip-lagrangian-fxf-inverse-adam-pretrain-8cb8598d09",
    ],
    "driven": [
        "sip-episodes1000-5db4e73935",
        "sip-truth-587f0e5f28",
        "sip-truth-sip-best-b5e2387847",
        "sip-truth-sip-best-2a55643e18",
    ],
}


@pytest.mark.parametrize("case", CASES)
def test_the_ids_of_stages_follow_from_settings_alone(case, monkeypatch):
    """The part of an id that is the code is held fixed; a change of settings or of their defaults changes these ids."""
    monkeypatch.setattr(code, "closure", lambda modules: Identity())
    composed = compose((*CASES[case], "scale=smoke"))
    assert [stage.id for stage in Pipeline.of(composed.config, composed.command).stages] == IDS[case]
