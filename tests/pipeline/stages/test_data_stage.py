"""The data stage writes what the generators make."""

import numpy as np
import pandas as pd

from repro.data.dataset import Dataset
from repro.data.random_force import random_force
from repro.mechanics.system import load
from repro.pipeline.stages.data import make_forced, make_free, read_recording, true_system


def test_the_true_system_is_the_one_asked_for():
    options = {"name": "sip", "damping": [0.1, 0.02], "damping_frame": "absolute", "m1": 0.3}
    assert true_system(options, "printed") == load("sip", "printed", [0.1, 0.02], "absolute", m1=0.3)


def test_forced_and_free_motion_are_written_as_made(tmp_path, system):
    summary = make_forced(tmp_path, system, [4], {"samples": 30, "episode_steps": 10, "tau_noise": 0.1})
    assert (summary["members"], summary["samples"], summary["n_train"]) == (1, 30, 24)
    expected = random_force(system, seeds=[4], samples=30, episode_steps=10, tau_noise=0.1)
    np.testing.assert_array_equal(Dataset.load(tmp_path).tau, expected.tau)
    make_free(tmp_path, system, [4], {"initial_angles": 5, "steps": 3, "time_step": 0.02})
    stored = Dataset.load(tmp_path)
    assert stored.energy.shape == (1, 15) and stored.time_step == 0.02


def test_a_recording_is_read_in_the_systems_coordinates(tmp_path, system):
    time = np.arange(20) * 0.05
    columns = {"time": time, "x": time, "angle": 2 * time, "f": time}
    columns |= {name: np.full(20, value) for name, value in (("xd", 1.0), ("w", 2.0), ("none", 0.0))}
    pd.DataFrame(columns).to_csv(tmp_path / "mine.csv", index=False)
    roles = {"time": ["time"], "q": ["x", "angle"], "qd": ["xd", "w"], "tau": ["f", "none"], "qdd": [], "episode": []}
    options = {"path": str(tmp_path / "mine.csv"), "columns": roles, "time_step": None, "train_fraction": 0.5}
    read_recording(tmp_path, system, [0, 1, 2], options)
    stored = Dataset.load(tmp_path)
    assert stored.members == 3 and stored.n_train == 10
    assert [c.name for c in stored.coordinates] == ["x", "theta"]
    np.testing.assert_allclose(stored.q[2, :, 1], 2 * time)
    np.testing.assert_allclose(stored.qdd, 0, atol=1e-12)
