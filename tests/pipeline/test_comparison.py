"""Several runs in one recording: what is shown is what was stored, and what cannot be shown together is refused."""

import numpy as np
import pandas as pd
import pytest

from repro.config.compose import compose
from repro.errors import UserError
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.pipeline.side_by_side import compared
from repro.recording.writer import read_recording
from repro.tracking.store import Store

TINY = ["scale=smoke", "data.samples=200", "data.episode_steps=100", "seeds=2", "record=false"]
RUNS = {
    "oracle": ["basis=t1", "optimiser=least_squares"],
    "small": ["optimiser.epochs=3"],
    "large": ["optimiser.epochs=3", "model.hidden=[12]"],
    "other_data": ["data.force_limit=3"],
    "no_motion": ["model=trivial"],
}


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A store and the ids of its runs by name."""
    root = tmp_path_factory.mktemp("outputs")
    found = {}
    for name, overrides in RUNS.items():
        composed = compose([*TINY, *overrides])
        found[name] = execute(Pipeline.of(composed.config, composed.command), Store(root))
    return root, found


def test_the_models_of_all_runs_are_beside_one_plant(stored):
    root, runs = stored
    names = ["oracle", "small", "large"]
    path = compared([runs[name].id for name in names], root)
    tracks = read_recording(path)
    angle = tracks["state/theta"]
    assert angle.names == (
        "θ plant [rad]",
        "θ T1/V1 [rad]",
        "θ T2/V1, 1x10 [rad]",
        "θ T2/V1, 1x12 [rad]",
    )
    for column, name in enumerate(names, start=1):
        rows = pd.read_parquet(runs[name].path("trajectories.parquet"))
        rows = rows[(rows["member"] == 0) & (rows["name"] == "model.theta")].sort_values("t")
        np.testing.assert_array_equal(angle.values[:, column], rows["value"])
    assert tracks["learning/log10_loss"].values.shape[1] == 2


def test_a_comparison_is_made_once(stored):
    root, runs = stored
    ids = [runs["small"].id, runs["large"].id]
    first = compared(ids, root)
    written = first.stat().st_mtime_ns
    assert compared([id.rpartition("-")[2] for id in ids], root) == first
    assert first.stat().st_mtime_ns == written


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["small", "other_data"], "different data"),
        (["small", "no_motion"], "no motion"),
        (["small", "small"], "named twice"),
    ],
)
def test_what_cannot_be_shown_together_is_refused(stored, names, said):
    root, runs = stored
    with pytest.raises(UserError, match=said):
        compared([runs[name].id for name in names], root)


def test_a_stage_that_is_no_run_is_refused(stored):
    root, runs = stored
    with pytest.raises(UserError, match="not a run"):
        compared([runs["small"].id, runs["small"].identity.upstream["data"]], root)
