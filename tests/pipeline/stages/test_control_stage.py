"""Closed loops as a stage: which are closed, what they leave, and that their recording shows them."""

import numpy as np
import pandas as pd
import pytest

from repro.config.registry import settings
from repro.data.random_force import random_force
from repro.mechanics.system import load
from repro.models.truth import Truth
from repro.pipeline.stages import close_loops as control
from repro.pipeline.stages import record_loop as loop_recording
from repro.recording.writer import read_recording

COLUMNS = [
    "member", "controller", "setting", "intervals", "horizon_s", "x_des", "start", "mismatch", "noise", "disturbance",
    "delay", "success", "contact", "clearance_min_m", "held_from_s", "steady_error_m", "solve_ms_median",
    "solve_ms_p95", "solve_ms_p99", "iterations_median", "fallbacks",
]  # fmt: skip


def options(group, name, **changes):
    return {**settings(group, name), **changes}


@pytest.fixture(scope="module")
def data():
    return random_force(
        load("sip"), seeds=[0, 1], regime="episodes", episode_steps=50, samples=200, train_fraction=0.8, time_step=0.04,
        force_limit=4.0, start="upright", reset="random", labels="exact", tau_noise=0.0, qdd_noise=0.0, q_noise=0.0,
        qd_noise=0.0, common=False,
    )  # fmt: skip


def drive(folder, plan, data):
    system = load("sip")
    model = Truth(system)
    weights = model.initial([np.random.default_rng(seed) for seed in (0, 1)])
    return control.drive(folder, model, weights, [0, 1], system, data, plan, lambda fraction, text: None)


@pytest.mark.parametrize("setting", ["sip", "sip_adaptive", "energy_shaping", "sip_printed"])
def test_a_setting_drives_and_leaves_its_rows(setting, tmp_path, data):
    task = options("task", "random", seconds=2.0, mismatch=0.1, noise=0.5)
    summary = drive(tmp_path, control.Plan(options("control", setting), task, 2, True), data)
    table = pd.read_parquet(tmp_path / control.LOOPS)
    assert set(COLUMNS) <= set(table) and len(table) == summary["loops"] == 2
    assert list(table["member"]) == [0, 1] and list(table["x_des"]) == [0.8, -0.8]
    assert set(table["setting"]) == {setting} and summary["success"] == table["success"].mean()
    shown = pd.read_parquet(tmp_path / control.TRAJECTORIES)
    assert set(shown["loop"]) == {0, 1} and {"x", "theta", "force", "T", "clearance", "end1.x"} <= set(shown["name"])


def test_a_hanging_start_is_driven_by_every_member_to_every_place():
    plan = control.Plan({}, options("task", "hanging", x_des=[0.8, 0.4]), 3, False)
    pairs = plan.starts(load("sip"), 2)
    assert [(start.x_des, member) for start, member in pairs] == [(0.8, 0), (0.8, 1), (0.4, 0)]


def test_random_starts_go_to_the_members_in_turn():
    plan = control.Plan({}, options("task", "random", initial_states=5), 50, False)
    pairs = plan.starts(load("dip"), 2)
    assert [(start.name, member) for start, member in pairs] == [(f"random {k}", k % 2) for k in range(5)]


def test_the_disc_is_the_papers_unless_it_is_said():
    def plan(**changes):
        return control.Plan(options("control", "sip"), options("task", "hanging", **changes), 1, False)

    assert [plan().obstacle(load(name)).radius for name in ("sip", "dip")] == [0.3, 0.1]
    assert plan(radius=0.2).obstacle(load("sip")).radius == 0.2
    assert plan(radius=0).obstacle(load("sip")) is None
    assert plan().obstacle(load("sip")).midpoints and plan().obstacle(load("sip")).weight == 1e6


def test_the_recording_shows_motion_solver_and_clearance(tmp_path, data):
    task = options("task", "hanging", seconds=2.0)
    drive(tmp_path, control.Plan(options("control", "sip"), task, 1, False), data)
    with np.load(tmp_path / control.FIRST) as stored:
        loop_recording.record(tmp_path, "run", "title", {"setting": "sip"}, dict(stored), load("sip"))
        states = stored["states"]
    tracks = read_recording(tmp_path / loop_recording.FILE)
    np.testing.assert_allclose(tracks["state/theta"].values[:, 0], states[::8, 1])
    assert {"further/solver_time", "further/iterations", "further/clearance", "force"} <= set(tracks)
    supplied, stored_power, _ = tracks["power"].values.T
    np.testing.assert_allclose(supplied, stored_power, atol=1e-3)
