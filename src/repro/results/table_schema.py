"""The columns of the result tables: the one place where they are named and typed. A member is known by its seed."""

import math
from collections.abc import Mapping
from typing import Any

from repro.results.columns import LOOP, RUN

Cell = str | int | float | None  # a value in a table

# What was run (see `columns`), and whether it is a protocol as the paper prints it.
CARD: Mapping[str, type] = {**{name: column.kind for name, column in RUN.items()}, "as_printed": bool}
LOOP_CARD: Mapping[str, type] = {name: column.kind for name, column in LOOP.items()}

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
# `config`: the settings of the run by dotted key, as JSON; `changed`: the keys of those that are not the usual ones,
# with blanks between them.
RUNS: Mapping[str, type] = {
    **PLACE,
    **CARD,
    "config": str,
    "changed": str,
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
# One row per closed loop.
CONTROL: Mapping[str, type] = {
    "run": str,
    "experiment": str,
    "scale": str,
    "member": int,
    **LOOP_CARD,
    "x_des": float,
    "start": str,
    "start_x": float,
    "start_theta": float,
    "start_theta1": float,
    "start_theta2": float,
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
# One row per stage of a run, upstream first; `libraries` and `config` as JSON.
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


def as_text(value: object) -> str:
    """Spell a value as text: the same spelling in the tables and in the selectors of the claims."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(as_text, value))}]"
    return str(value)


def plain(value: Any) -> Any:
    """Take one cell out of a table: a Python value, None where it is missing."""
    import pandas as pd

    if pd.api.types.is_scalar(value) and pd.isna(value):
        return None
    return value.item() if hasattr(value, "item") else value


def as_column(kind: type, value: Any) -> Cell:
    """Bring one value to its column's type; None stays None for numbers and becomes empty text."""
    if kind is str:
        return as_text(value)
    typed: Cell = None if value is None else kind(value)
    return typed
