"""Control in the report: predicates, tables, figures and animations from stored closed loops."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from repro.claims.predicate_registry import ask, check_predicate
from repro.claims.predicates import Evidence
from repro.report.animation import animate_all
from repro.report.figures import closed_loop, success_map
from repro.report.tables.closed_loops import control_tables
from repro.results.results import Results, typed
from repro.results.schema import TABLES
from repro.results.selectors import NotRunError
from repro.results.stored_loop import find_loop

EXPERIMENT = "sip_control"


def loop(number, success, **others):
    asked = {
        "run": "run-1", "experiment": EXPERIMENT, "scale": "paper", "system": "sip", "model": "truth", "member": 0,
        "controller": "mpc", "setting": "sip", "intervals": 20, "horizon_s": 0.8, "x_des": 0.8, "task": "random",
        "start": f"random {number}", "start_x": 0.01 * number, "start_theta": 3.0 + 0.01 * number, "seconds": 10.0,
        "mismatch": 0.0, "noise": 0.0, "disturbance": 0.0, "delay": 0.0, "mismatch_kind": "coefficients",
    }  # fmt: skip
    came = {
        "success": success, "contact": False, "clearance_min_m": 0.1, "held_from_s": 1.0 if success else np.nan,
        "steady_error_m": 1e-4, "solve_ms_median": 10.0 + number, "solve_ms_p95": 20.0, "solve_ms_p99": 30.0,
        "iterations_median": 5.0, "fallbacks": 6, "fallbacks_1": 3, "fallbacks_2": 2, "fallbacks_3": 1, "killed": 0,
    }  # fmt: skip
    return {**asked, **came, **others}


def moving(run="run-1"):
    """Two seconds of a link that turns up, at the control steps."""
    time = np.arange(51) * 0.04
    angle = np.pi * np.clip(1 - time, 0, None)
    series = {
        "x": 0.4 * time, "theta": angle, "xd": 0.4 + 0 * time, "thetad": -np.pi * (time < 1), "T": 0.1 + 0 * time,
        "V": np.cos(angle), "H": 0.1 + np.cos(angle), "force": np.append(np.sign(np.sin(9 * time[:-1])), np.nan),
        "clearance": 0.2 + 0 * time, "end1.x": 0.4 * time + 0.5 * np.sin(angle), "end1.y": 0.5 * np.cos(angle),
    }  # fmt: skip
    rows = [("obstacle.x", 0.0, 0.0), ("obstacle.y", 0.0, 0.6), ("obstacle.radius", 0.0, 0.3)]
    rows += [(name, t, v) for name, values in series.items() for t, v in zip(time, values, strict=True)]
    table = pd.DataFrame(rows, columns=["name", "t", "value"])
    return table.assign(run=run, loop=0, member=0, x_des=0.8)


def results(loops, trajectories=None):
    empty = {name: typed(name, pd.DataFrame()) for name in TABLES}
    runs = [
        {"run": name, "experiment": EXPERIMENT, "command": f"repro run {name}"} for name in {r["run"] for r in loops}
    ]
    empty["runs"] = typed("runs", runs)
    made = Results(**empty)
    stored = typed("closed_loops", pd.DataFrame() if trajectories is None else trajectories)
    return replace(made, control=typed("control", loops), closed_loops=stored)


def asked(results, predicate):
    check_predicate(predicate, "here")
    return ask(predicate, Evidence(results, EXPERIMENT))


@pytest.mark.parametrize(("successes", "holds"), [(10, True), (9, True), (8, False)])
def test_the_share_of_loops_that_succeed(successes, holds):
    stored = results([loop(k, k < successes) for k in range(10)])
    found = asked(stored, {"name": "loops_succeed", "share_of_loops": 0.9, "loops": {"setting": "sip"}})
    assert (found.holds, found.estimate.median, found.estimate.n) == (holds, successes / 10, 10)
    assert found.estimate.low < successes / 10 and found.runs == ("run-1",) and found.commands == ("repro run run-1",)


def test_more_often_means_interval_against_interval():
    question = {
        "name": "loops_succeed_more_often", "loops": {"setting": "sip"}, "other_loops": {"setting": "set_point_square"}
    }  # fmt: skip
    ours = [loop(k, True) for k in range(20)]

    def others(successes):
        return [loop(k, k < successes, setting="set_point_square", run="run-2") for k in range(20)]

    assert asked(results(ours + others(2)), question).holds
    assert not asked(results(ours + others(18)), question).holds
    assert set(asked(results(ours + others(2)), question).runs) == {"run-1", "run-2"}


def test_step_times():
    stored = results([loop(k, True) for k in range(5)])
    question = {"name": "step_takes_longer", "loops": {"model": "truth"}}
    assert asked(stored, {**question, "milliseconds": 11.5}).holds
    assert not asked(stored, {**question, "milliseconds": 12.0}).holds


def test_what_was_not_run_is_said():
    question = {"name": "loops_succeed", "share_of_loops": 0.9, "loops": {"setting": "dip"}}
    for stored in (results([]), results([loop(0, True)])):
        with pytest.raises(NotRunError, match="no closed loop of sip_control with setting=dip"):
            asked(stored, question)


def test_a_table_has_a_row_for_whatever_differs():
    loops = [loop(k, k != 0) for k in range(4)] + [loop(k, False, mismatch=0.1, contact=True) for k in range(2)]
    (table,) = control_tables(results(loops))
    assert [row.data["mismatch"] for row in table.rows] == ["0", "0.1"]
    first, second = (row.data for row in table.rows)
    assert (first["loops"], first["success"], second["success"], second["contacts"]) == (4, 0.75, 0.0, 2)
    assert second["held_from_s"] is None and first["solve_ms_median"] == 11.5
    assert [first[f"fallbacks_{level}"] for level in (1, 2, 3)] == [3, 2, 1]
    assert "delay" not in first, "what is the same everywhere is not a column"


def test_a_stored_loop_is_found_by_the_first_choice_that_was_run():
    stored = results([loop(0, True)], moving())
    found = find_loop(stored, EXPERIMENT, ({"model": "structured"}, {"model": "truth", "intervals": 20}))
    assert found.points.shape == (51, 2, 2) and found.obstacle == (0.0, 0.6, 0.3)
    np.testing.assert_allclose(found.points[-1], [[0.8, 0.0], [0.8, 0.5]])
    assert found.angles == ["theta"] and found.time[found.settled] == pytest.approx(1.0)
    assert find_loop(stored, EXPERIMENT, ({"model": "structured"},)) is None


def test_figures_and_animations_are_written_where_there_is_something_to_show(tmp_path):
    stored = results([loop(k, k > 0) for k in range(3)], moving())
    assert closed_loop.SINGLE.save(stored, tmp_path) and success_map.FIGURE.save(stored, tmp_path)
    assert not closed_loop.DOUBLE.save(stored, tmp_path)
    (path,) = animate_all(stored, tmp_path)
    assert path.name == "sip_swing_up.gif" and path.read_bytes()[:6] == b"GIF89a"
    assert animate_all(results([]), tmp_path) == []
