"""The columns of the result tables: the one place where they are named and typed. A member is known by its seed."""

import json
import math
from collections.abc import Mapping
from typing import Any

# The run card: what was chosen for a run. `seeds` and `member_status` belong to the members, not to the setting.
CARD: Mapping[str, type] = {
    "system": str,
    "reading": str,
    "regime": str,
    "labels": str,
    "noise": str,
    "model": str,
    "basis": str,
    "hidden": str,
    "options": str,
    "objective": str,
    "optimiser": str,
    "sequence": str,
    "grid": str,
    "pretraining_epochs": int,
    "reset": str,
    "tau_noise": float,
    "qdd_noise": float,
    "damping": str,
    "n_train": int,
    "episode_steps": int,
    "energies": str,
    "energy_form": str,
    "momentum_weight": float,
    "momentum_hidden": str,
    "curriculum": str,
    "epochs": int,
    "literal": bool,
}

# What a run card says of its members and of how the fit went, not of what was chosen.
NOT_CHOSEN = ("seeds", "member_status", "notes")

# What the test set depends on: two settings that agree here were judged on the same data.
TEST_SET = ("system", "reading", "regime", "episode_steps", "reset", "damping")

PLACE: Mapping[str, type] = {"run": str, "experiment": str, "scale": str, "setting": str}

METRICS: Mapping[str, type] = {
    **PLACE,
    **CARD,
    "member": int,
    "split": str,
    "metric": str,
    "value": float,
    "unit": str,
}
RUNS: Mapping[str, type] = {
    **PLACE,
    **CARD,
    "outcome": str,
    "error": str,
    "stale": bool,
    "seeds": list,
    "member_status": list,
    "command": str,
}
CURVES: Mapping[str, type] = {"run": str, "member": int, "step": int, "name": str, "value": float}
TRAJECTORIES: Mapping[str, type] = {"run": str, "member": int, "name": str, "t": float, "value": float}
IDENTIFIABILITY: Mapping[str, type] = {
    "run": str,
    "member": int,
    "phase": str,
    "order": int,
    "value": float,
    "direction": str,
}
BENCH: Mapping[str, type] = {
    "run": str,
    "name": str,
    "ours": str,
    "other": str,
    "size": str,
    "members": int,
    "ratio_median": float,
    "ratio_q25": float,
    "ratio_q75": float,
    "ours_ms": float,
    "other_ms": float,
    "ours_mib": float,
    "other_mib": float,
    "threads": int,
    "protocol": str,
    "command": str,
}
# One row a closed loop; the columns of DESIGN first, then what else was asked of it.
CONTROL: Mapping[str, type] = {
    "run": str,
    "experiment": str,
    "scale": str,
    "system": str,
    "model": str,
    "member": int,
    "controller": str,
    "setting": str,
    "intervals": int,
    "horizon_s": float,
    "x_des": float,
    "start": str,
    "mismatch": float,
    "noise": float,
    "disturbance": float,
    "delay": float,
    "success": bool,
    "contact": bool,
    "clearance_min_m": float,
    "held_from_s": float,
    "steady_error_m": float,
    "solve_ms_median": float,
    "solve_ms_p95": float,
    "solve_ms_p99": float,
    "iterations_median": float,
    "fallbacks": int,
    "fallbacks_1": int,
    "fallbacks_2": int,
    "fallbacks_3": int,
    "killed": int,
    "basis": str,
    "hidden": str,
    "objective": str,
    "optimiser": str,
    "energies": str,
    "adaptive": bool,
    "discretisation": str,
    "solver": str,
    "task": str,
    "mismatch_kind": str,
    "friction": str,
    "seconds": float,
    "start_x": float,
    "start_theta": float,
    "start_theta1": float,
    "start_theta2": float,
}
CLOSED_LOOPS: Mapping[str, type] = {
    "run": str,
    "loop": int,
    "member": int,
    "x_des": float,
    "name": str,
    "t": float,
    "value": float,
}
# One row a stage of a run, upstream first; `libraries` and `config` as JSON.
STAGES: Mapping[str, type] = {
    "run": str,
    "stage": str,
    "id": str,
    "started": str,
    "wall_s": float,
    "cpu_s": float,
    "peak_memory_mib": float,
    "commit": str,
    "clean": bool,
    "python": str,
    "system": str,
    "processor": str,
    "cores": int,
    "libraries": str,
    "config": str,
}
TABLES: Mapping[str, Mapping[str, type]] = {
    "metrics": METRICS,
    "runs": RUNS,
    "curves": CURVES,
    "trajectories": TRAJECTORIES,
    "bench": BENCH,
    "identifiability": IDENTIFIABILITY,
    "control": CONTROL,
    "closed_loops": CLOSED_LOOPS,
    "stages": STAGES,
}

PANDAS_TYPES: Mapping[type, str] = {str: "str", float: "float64", int: "Int64", bool: "boolean", list: "object"}


def as_text(value: Any) -> str:
    """Spell a card value as text: the same spelling in the tables and in the selectors of the claims."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return f"{value:g}"
    return json.dumps(value)


def plain(value: Any) -> Any:
    """Take one cell out of a table: a Python value, None where it is missing."""
    import pandas as pd

    if pd.api.types.is_scalar(value) and pd.isna(value):
        return None
    return value.item() if hasattr(value, "item") else value


def as_card_value(column: str, value: Any) -> Any:
    """Bring one card value to its column's type; None stays None for numbers and becomes empty text."""
    kind = CARD[column]
    if kind is str:
        return as_text(value)
    return None if value is None else kind(value)
