"""Tables of closed loops with chosen outcomes, as gathered results."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd

from repro.results.results import Results, typed
from repro.results.table_schema import TABLES

EXPERIMENT = "sip_control"
SETTINGS = {"system.name": "sip", "system.damping": [], "reading.name": "physical"}


def loop(number, success, **others):
    chosen = {
        "run": "run-1", "experiment": EXPERIMENT, "scale": "paper", "system": "sip", "model": "truth", "member": 0,
        "controller": "mpc", "setting": "sip", "intervals": 20, "horizon_s": 0.8, "x_des": 0.8, "task": "random",
        "start": f"random {number}", "start_x": 0.01 * number, "start_theta": 3.0 + 0.01 * number, "seconds": 10.0,
        "mismatch": 0.0, "noise": 0.0, "disturbance": 0.0, "delay": 0.0, "mismatch_kind": "coefficients",
    }  # fmt: skip
    measured = {
        "success": success, "contact": False, "clearance_min_m": 0.1, "held_from_s": 1.0 if success else np.nan,
        "steady_error_m": 1e-4, "solve_ms_median": 10.0 + number, "solve_ms_p95": 20.0, "solve_ms_p99": 30.0,
        "iterations_median": 5.0, "fallbacks": 6, "fallbacks_1": 3, "fallbacks_2": 2, "fallbacks_3": 1, "killed": 0,
    }  # fmt: skip
    return {**chosen, **measured, **others}


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


def results(loops, trajectories=None, experiment=EXPERIMENT, **settings):
    """Results with these loops, their motion, and further settings of their runs by dotted key."""
    empty = {name: typed(name, pd.DataFrame()) for name in TABLES}
    config = json.dumps({**SETTINGS, **settings})
    runs = [
        {"run": name, "experiment": experiment, "command": f"repro run {name}", "config": config}
        for name in {r["run"] for r in loops}
    ]
    empty["runs"] = typed("runs", runs)
    made = Results(**empty)
    stored = typed("closed_loops", pd.DataFrame() if trajectories is None else trajectories)
    return replace(made, control=typed("control", loops), closed_loops=stored)
