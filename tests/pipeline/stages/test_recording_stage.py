"""What is drawn is what was stored."""

import numpy as np
import pandas as pd
import pytest
from simulated import random_force

from repro.library import run_recording as module
from repro.library.ensemble_model import Ensemble
from repro.library.run_recording import record
from repro.mechanics.system import load
from repro.models.bases import rigid_body
from repro.models.damped import Damped
from repro.models.gauge import Gauge
from repro.models.lagrangian import Lagrangian
from repro.models.position import position_features
from repro.pipeline.stages.evaluate import TRAJECTORIES, measure
from repro.recording.contents import FILENAME

CURVES = pd.DataFrame(
    [(seed, step, "loss", value) for seed in (3, 8) for step, value in ((1, 10.0), (2, 0.01), (3, 0.0))],
    columns=["member", "step", "name", "value"],
)


@pytest.fixture
def recorded(tmp_path, exact, system, monkeypatch):
    """The recording that would be written for the exact model."""
    measure(tmp_path, exact, Gauge.RAW)
    written = []
    monkeypatch.setattr(module, "write_recording", lambda path, recording: written.append(recording))
    trajectories = pd.read_parquet(tmp_path / TRAJECTORIES)
    summary = record(tmp_path / "recording.rrd", "run-1", "a title", {"key": 1}, trajectories, CURVES, system)
    assert summary == {"member": 3}
    return written[0]


def test_plant_and_model_are_the_first_members(recorded, data):
    test = data.test
    np.testing.assert_array_equal(recorded.plant.state, np.concatenate([test.q[0], test.qd[0]], axis=-1))
    np.testing.assert_allclose(recorded.models["seed 3"].state, recorded.plant.state, atol=1e-8)
    np.testing.assert_array_equal(recorded.forces["x"], test.tau[0, :, 0])
    assert list(recorded.forces) == ["x"]


def test_points_are_the_cart_and_a_tip_at_the_length_of_the_pole(recorded):
    cart, tip = np.moveaxis(recorded.plant.shapes[1].points, 1, 0)
    np.testing.assert_array_equal(cart[:, 1], 0)
    np.testing.assert_array_equal(cart[:, 0], recorded.plant.state[:, 0])
    np.testing.assert_allclose(np.linalg.norm(tip - cart, axis=1), 0.5)


def test_supplied_power_is_stored_or_dissipated(recorded, data):
    """No damping: f dx/dt = dH/dt in every step, and a restart is not a step."""
    power = recorded.power
    restart = np.flatnonzero(np.diff(data.test.episode))
    assert restart.tolist() == [19]
    np.testing.assert_allclose(power["dissipated"], 0, atol=1e-3)
    for values in power.values():
        assert values[19] == 0 and values[-1] == 0
    assert np.abs(power["supplied"]).max() > 0.1


def test_the_power_of_all_inputs_is_stored_or_lost_in_the_damping(tmp_path, monkeypatch):
    """A damped rod under two forces and a torque: what the recording calls dissipated is its Rayleigh power."""
    damping = np.array([0.1, 0.2, 0.01])
    rod = load("rod", damping=damping.tolist())
    driven = random_force(rod, seeds=[3], samples=2000, episode_steps=150, time_step=0.001, force_limit=0.5)
    model = Damped(Lagrangian(rigid_body, 3), "diagonal", position_features(rod.coordinates))
    weights = np.array([[0.1, 0.002, 1.96, *damping]])
    measure(tmp_path, Ensemble(model, weights, (3,), driven, ("ok",), 1.0, system=rod), Gauge.RAW)
    written = []
    monkeypatch.setattr(module, "write_recording", lambda path, recording: written.append(recording))
    record(tmp_path / "recording.rrd", "run-1", "a title", {}, pd.read_parquet(tmp_path / TRAJECTORIES), CURVES, rod)
    (shown,) = written
    assert list(shown.forces) == ["x", "y", "theta"]
    lost = np.sum(damping * shown.plant.state[:, 3:] ** 2, axis=1)
    within = np.flatnonzero(np.diff(driven.test.episode[: len(lost)]) == 0)
    assert len(within) < len(lost) - 1
    mean = (lost[within] + lost[within + 1]) / 2
    np.testing.assert_allclose(shown.power["dissipated"][within], mean, atol=1e-4)
    assert lost.max() > 0.01


def test_curves_are_drawn_on_a_logarithmic_scale_without_zeros(recorded):
    curve = recorded.curves["log10 loss"]
    np.testing.assert_array_equal(curve.step, [1, 2, 3])
    np.testing.assert_allclose(curve.values["seed 8"], [1, -2, np.nan])


def test_a_quantity_that_changes_its_sign_is_drawn_as_it_is():
    least = pd.DataFrame({"step": [0, 10, 20], "name": "min_eig_M", "value": [-0.2, 0.01, 0.04]})
    curve = module._curves({"seed 3": least})["min_eig_M"]
    np.testing.assert_array_equal(curve.values["seed 3"], [-0.2, 0.01, 0.04])


def test_curves_of_unlike_steps_are_held_and_end_with_their_last():
    short = pd.DataFrame({"step": [1, 4], "name": "loss", "value": [10.0, 1.0]})
    long = pd.DataFrame({"step": [1, 2, 6], "name": "loss", "value": [100.0, 10.0, 1.0]})
    curve = module._curves({"short": short, "long": long})["log10 loss"]
    np.testing.assert_array_equal(curve.step, [1, 2, 4, 6])
    np.testing.assert_array_equal(curve.values["short"], [1, 1, 0, np.nan])
    np.testing.assert_array_equal(curve.values["long"], [2, 1, 1, 0])


def test_a_recording_is_written(tmp_path, exact, system):
    measure(tmp_path, exact, Gauge.RAW)
    trajectories = pd.read_parquet(tmp_path / TRAJECTORIES)
    record(tmp_path / "recording.rrd", "run-1", "a title", {}, trajectories, CURVES, system)
    assert (tmp_path / FILENAME).stat().st_size > 1000
