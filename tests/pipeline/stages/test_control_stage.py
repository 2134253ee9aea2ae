"""Closed loops as a stage: which are run, what they write, and that their recording shows them."""

import numpy as np
import pandas as pd
import pytest
from configurations import changed
from simulated import random_force

from repro.config.registry import groups, settings
from repro.control.controller import CONTROLLERS
from repro.control.predictive_model import PredictiveModel
from repro.control.task import LoopPlan, Task
from repro.errors import UserError
from repro.library.ensemble_model import Ensemble
from repro.mechanics.system import load
from repro.models.kinds.truth import Truth, true_model
from repro.pipeline.stages import close_loops as control
from repro.pipeline.stages import record_loop as loop_recording
from repro.plugins.checked import checked
from repro.plugins.plugin import plugin, plugin_names
from repro.recording.writer import read_recording

COLUMNS = [
    "member", "x_des", "start", "success", "contact", "clearance_min_m", "held_from_s", "steady_error_m",
    "solve_ms_median", "solve_ms_p95", "solve_ms_p99", "iterations_median", "fallbacks",
]  # fmt: skip


def controller(name):
    return checked("control", CONTROLLERS, settings("control", name))


def task(name, **changes):
    return Task(**settings("task", name) | changes)


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
    return control.drive(folder, Ensemble(model, weights, (0, 1), data, system=system), plan)


@pytest.mark.parametrize("setting", ["sip", "sip_adaptive", "energy_shaping", "sip_printed"])
def test_a_setting_drives_and_leaves_its_rows(setting, tmp_path, data):
    disturbed = task("random", seconds=2.0, mismatch=0.1, noise=0.5)
    summary = drive(tmp_path, LoopPlan(controller=controller(setting), task=disturbed, loops=2, canonical=True), data)
    table = pd.read_parquet(tmp_path / control.LOOPS)
    assert set(COLUMNS) <= set(table) and len(table) == summary["loops"] == 2
    assert list(table["member"]) == [0, 1] and list(table["x_des"]) == [0.8, -0.8]
    assert summary["success"] == table["success"].mean()
    shown = pd.read_parquet(tmp_path / control.TRAJECTORIES)
    assert set(shown["loop"]) == {0, 1} and {"x", "theta", "force", "T", "clearance", "end1.x"} <= set(shown["name"])


@pytest.mark.parametrize("system", plugin_names("mechanics.systems"))
@pytest.mark.parametrize("setting", [name for name in groups()["control"] if name != "none"])
def test_every_system_and_controller_make_a_step_or_are_refused_in_one_line(system, setting):
    chosen = settings("control", setting)
    short = {"intervals": 2, "coarse_intervals": 0, "solver": "ipopt"} if chosen["kind"] == "mpc" else {}
    constants = {"n": 1} if system == "cart_rods" else {}
    plant = load(system, **constants)
    states = list(plant.rest_states)
    groups = {
        "system": settings("system", system) | constants,
        "control": chosen | short,
        "task": settings("task", "swing_up") | {"start": states[-1], "end": states[0]},
    }
    try:
        config = changed(("model=truth",), **groups)
    except UserError as refused:
        driven = f"control = {setting!r}: drives a cart with one link "
        assert str(refused).startswith(
            "control.adaptive = True: model=truth: has no " if "adaptive" in setting else driven
        )
        assert f"system={system}" in str(refused) and len(str(refused).splitlines()) == 1
        return
    model, options = true_model(plant, damped=False), config.control
    (weights,) = model.initial([np.random.default_rng(0)])
    samples = np.random.default_rng(0).normal(size=(3, 50, plant.n_q))
    (start, _), *_ = config.task.starts(plant, 1)
    with plugin(CONTROLLERS, options.kind).build(options, PredictiveModel(model, plant), None, samples) as make:
        step = make(weights, start.goal).decide(start.state)
    assert step.u.shape == (len(plant.inputs),) and np.all(np.abs(step.u) <= options.limits(plant))


def test_energy_shaping_drives_a_cart_with_one_link():
    systems = plugin_names("mechanics.systems")
    assert all(controller("sip").fits(load(name)) for name in systems)
    assert {name for name in systems if controller("energy_shaping").fits(load(name))} == {"sip", "sip_rod"}
    assert controller("energy_shaping").fits(load("cart_rods", n=1))


def test_a_hanging_start_is_driven_by_every_member_to_every_place():
    pairs = task("hanging", x_des=[0.8, 0.4]).starts(load("sip"), 2)
    assert [(start.goal.place("x"), member) for start, member in pairs] == [(0.8, 0), (0.8, 1), (0.4, 0), (0.4, 1)]
    assert task("hanging", x_des=[0.8, 0.4]).n_loops(2) == 4


def test_random_starts_go_to_targets_and_members_in_turn():
    pairs = task("random", initial_states=5).starts(load("dip"), 2)
    assert [(start.name, member) for start, member in pairs] == [(f"random {k}", k % 2) for k in range(5)]
    assert [start.goal.place("x") for start, _ in pairs] == [0.8, -0.8, 0.8, -0.8, 0.8]


def test_the_disc_is_the_papers_unless_another_is_chosen():
    assert [task("hanging").disc(load(name)).radius for name in ("sip", "dip")] == [0.3, 0.1]
    assert task("hanging", radius=0.2).disc(load("sip")).radius == 0.2
    assert task("hanging", radius=0).disc(load("sip")) is None
    obstacle = controller("sip").problem(task("hanging").disc(load("sip")), load("sip")).obstacle
    assert obstacle.midpoints and obstacle.weight == 1e6 and obstacle.radius == 0.3


def test_the_recording_shows_motion_solver_and_clearance(tmp_path, data):
    plan = LoopPlan(controller=controller("sip"), task=task("hanging", seconds=2.0), loops=1, canonical=False)
    drive(tmp_path, plan, data)
    with np.load(tmp_path / control.FIRST) as stored:
        loop_recording.record(tmp_path, "run", "title", {"setting": "sip"}, dict(stored), load("sip"))
        states = stored["states"]
    tracks = read_recording(tmp_path / "recording.rrd")
    np.testing.assert_allclose(tracks["state/theta"].values[:, 0], states[::8, 1])
    assert {"further/solver_time", "further/iterations", "further/clearance", "force"} <= set(tracks)
    assert tracks["further/fallback"].names == ("1 second try, 2 last plan, 3 none",)
    supplied, stored_power, _ = tracks["power"].values.T
    np.testing.assert_allclose(supplied, stored_power, atol=1e-3)
