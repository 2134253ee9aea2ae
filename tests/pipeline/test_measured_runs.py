"""The experiment measured with other seeds than the published ones: networks, what they swing up, noise, encoders."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from repro.config.compose import compose
from repro.config.overrides import expand
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.record import Record
from repro.tracking.store import Store

SEEDS = "[400,401,402,403]"
JOBS = expand(["experiment=measured", "scale=paper", f"seeds={SEEDS}"])
RECORDED = {"B": "data.measured=states", "D": "data.measured=positions"}
PATH_OF_NETWORK = {"model=structured", "objective=path"}
LEVELS = {"B": {"q": 1e-3, "qd": 1e-2}, "D": {"q": 1e-3}}
SWINGS_UP = 0.92  # share of the starts


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(Path(tmp_path_factory.mktemp("measured")))


def _run(store: Store, words: set[str], without: str = "no such word") -> Record:
    """The run of the only job of the experiment with these words."""
    (job,) = [job for job in JOBS if words <= {*job} and not any(word.startswith(without) for word in job)]
    composed = compose([*job, "record=false"])
    return execute(Pipeline.of(composed.config, composed.command), store)


def _values(run: Record, metric: str) -> pd.Series:
    """One value per seed, of the test data where an error is known of both parts."""
    table = run.table("metrics")
    of = table[table["metric"] == metric]
    return of[of["split"] == of["split"].min()].set_index("member")["value"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("system", "recorded", "bar", "seconds"),
    [("sip", "B", 0.03, 20), ("sip", "D", 0.05, 20), ("dip", "B", 0.15, 60), ("dip", "D", 0.2, 60)],
)
def test_every_network_is_accurate(system: str, recorded: str, bar: float, seconds: float, store: Store) -> None:
    run = _run(store, PATH_OF_NETWORK | {f"system={system}", RECORDED[recorded]}, without="control=")
    errors = _values(run, "mae_qdd")
    assert len(errors) == 4
    assert errors.max() < bar
    assert _values(run, "trapped").sum() == 0
    assert _values(run, "cost_per_dof").median() == pytest.approx(1, abs=0.05)
    assert _values(run, "fit_seconds").max() < seconds


@pytest.mark.slow
def test_networks_from_positions_alone_swing_up(store: Store) -> None:
    loops = _run(store, PATH_OF_NETWORK | {"control=dip_best"}).table("control")
    assert len(loops) == 50
    assert loops["success"].mean() >= SWINGS_UP


@pytest.mark.slow
@pytest.mark.parametrize("recorded", RECORDED)
@pytest.mark.parametrize("basis", ["t1", "fxf"])
def test_noise_levels_are_estimated(basis: str, recorded: str, store: Store) -> None:
    run = _run(store, {f"basis={basis}", RECORDED[recorded], "objective.path.noise=estimated"})
    n_q = 2 if basis == "t1" else 3
    levels = [level for level in LEVELS[recorded].values() for _ in range(n_q)]
    found = np.array([_values(run, f"sensor_noise[{number}]") for number in range(len(levels))])
    assert np.abs(found / np.array(levels)[:, None] - 1).max() < 0.05


@pytest.mark.slow
def test_friction_and_the_zero_of_an_encoder_are_found(store: Store) -> None:
    run = _run(store, {"data.encoder_zero=0.02", "objective.path.zeros=angles"})
    for joint in (0, 1):
        assert _values(run, f"damping_error[{joint}]").max() < 0.01
    assert (_values(run, "encoder_zero[0]") - 0.02).abs().max() < 1e-4
