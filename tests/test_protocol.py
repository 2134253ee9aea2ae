"""Only what the paper printed counts as its protocol."""

import pytest

from repro.compose import compose
from repro.config import scaled
from repro.protocol import is_literal

WIDE = "model.hidden=[500,500]"


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
    assert is_literal(scaled(compose([*overrides, "scale=paper"]).config))
    assert not is_literal(scaled(compose([*overrides, "scale=quick"]).config))


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
    assert not is_literal(scaled(compose(overrides).config))
