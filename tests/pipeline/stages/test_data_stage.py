"""The data stage writes what the generators make."""

import numpy as np
import pandas as pd
from simulated import random_force

from repro.data.data_options import Columns, FreeMotionOptions, RandomForce, RecordingFile
from repro.data.dataset import Dataset
from repro.mechanics.system import load, load_system
from repro.mechanics.system_options import SystemOptions
from repro.pipeline.stage_options import DataOptions
from repro.pipeline.stages.data import make

SIP = SystemOptions("sip")


def test_the_true_system_is_the_one_asked_for():
    options = SystemOptions("sip", "printed", (0.1, 0.02), "absolute", constants={"m1": 0.3})
    assert load_system(options) == load("sip", "printed", [0.1, 0.02], damping_frame="absolute", m1=0.3)


def test_forced_and_free_motion_are_written_as_made(tmp_path, system):
    summary = make(tmp_path, DataOptions(SIP, (4,), RandomForce(samples=30, episode_steps=10, tau_noise=0.1)), {})
    assert (summary["members"], summary["samples"], summary["n_train"]) == (1, 30, 24)
    expected = random_force(system, seeds=[4], samples=30, episode_steps=10, tau_noise=0.1)
    np.testing.assert_array_equal(Dataset.load(tmp_path).tau, expected.tau)
    make(tmp_path, DataOptions(SIP, (4,), FreeMotionOptions(initial_angles=5, steps=3, time_step=0.02)), {})
    stored = Dataset.load(tmp_path)
    assert stored.energy.shape == (1, 15) and stored.time_step == 0.02


def test_a_recording_is_read_in_the_systems_coordinates(tmp_path):
    time = np.arange(20) * 0.05
    columns = {"time": time, "x": time, "angle": 2 * time, "f": time}
    columns |= {name: np.full(20, value) for name, value in (("xd", 1.0), ("w", 2.0), ("none", 0.0))}
    pd.DataFrame(columns).to_csv(tmp_path / "mine.csv", index=False)
    roles = Columns(time=("time",), q=("x", "angle"), qd=("xd", "w"), tau=("f", "none"))
    source = RecordingFile("file", str(tmp_path / "mine.csv"), roles, None, 0.5)
    make(tmp_path, DataOptions(SIP, (0, 1, 2), source), {})
    stored = Dataset.load(tmp_path)
    assert stored.members == 3 and stored.n_train == 10
    assert [c.name for c in stored.coordinates] == ["x", "theta"]
    np.testing.assert_allclose(stored.q[2, :, 1], 2 * time)
    np.testing.assert_allclose(stored.qdd, 0, atol=1e-12)
