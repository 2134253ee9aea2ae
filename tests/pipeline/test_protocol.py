"""Only what the paper printed counts as its protocol."""

from pathlib import Path

import pytest

from repro.config.compose import compose
from repro.config.schema import Config, scaled
from repro.pipeline.card import used_settings
from repro.results.gather import Gathering

PAPER = Gathering.load(Path(__file__).parents[2] / "paper")
WIDE = "model.hidden=[500,500]"


def _as_printed(config: Config) -> bool:
    return PAPER.is_as_printed(used_settings(scaled(config)))


@pytest.mark.parametrize(
    "overrides",
    [
        ["basis=t1"],
        ["basis=t1", "objective=forward"],
        ["basis=t2", "optimiser.epochs=5000"],
        ["basis=t2", "objective=forward", WIDE],
        ["basis=t1", "data=long", "seeds=3", "optimiser.precision=float32"],
    ],
)
def test_the_printed_protocols(overrides):
    assert _as_printed(compose([*overrides, "scale=paper"]).config)
    assert not _as_printed(compose([*overrides, "scale=quick"]).config)


@pytest.mark.parametrize(
    "change",
    [
        "optimiser=adam_cosine",
        "optimiser=least_squares",
        "optimiser.epochs=999",
        "optimiser.learning_rate=0.001",
        "data.samples=50000",
        "data.labels=differenced",
        "data.reset=random",
        "data.start=hanging",
        "data.tau_noise=0.1",
        "basis=t2",
        "system.damping=[0.1,0.1]",
        "curriculum=growing_episodes",
        "objective.l1_kinetic=0.001",
        "sequence=joint",
        "model=trivial",
    ],
)
def test_anything_else_is_not(change):
    overrides = ["basis=t1", "scale=paper", change]
    if change.startswith("basis"):
        overrides.remove("basis=t1")
    assert not _as_printed(compose(overrides).config)


DIP = ("system=dip", "basis=fxf", "data.force_limit=4", "objective.l1_kinetic=1e-5")
PRETRAINED = (*DIP, "sequence=pretrain", "sequence.pretraining_epochs=1000", "optimiser.epochs=8000")


@pytest.mark.parametrize("protocol", [PRETRAINED, (*PRETRAINED, "data=long"), (*DIP, "sequence=pretrain_only")])
def test_the_printed_protocols_of_the_double_pendulum(protocol):
    assert _as_printed(compose([*protocol, "scale=paper"]).config)
    assert not _as_printed(compose([*protocol, "scale=quick"]).config)


@pytest.mark.parametrize(
    "change",
    [
        "system.m2=0.3",
        "basis=fxf_gauge",
        "data.force_limit=5",
        "objective.l1_kinetic=0",
        "objective.l1_potential=1e-5",
        "sequence=main",
        "sequence.pretraining_epochs=500",
        "sequence.grid=diagonal",
        "sequence.initial_angles=10",
        "optimiser.epochs=1000",
        "optimiser=adam_cosine",
    ],
)
def test_anything_else_is_not_the_double_pendulum_s(change):
    replaced = [o for o in PRETRAINED if o.partition("=")[0] != change.partition("=")[0]]
    if change == "sequence=main":
        replaced.remove("sequence.pretraining_epochs=1000")
    assert not _as_printed(compose([*replaced, "scale=paper", change]).config)
