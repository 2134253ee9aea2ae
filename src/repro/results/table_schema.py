"""The columns of the result tables: the one place where they are named and typed. A member is known by its seed."""

import math
from collections.abc import Mapping
from typing import Any

from repro.results.columns import LOOP, RUN
from repro.tracking.lazy_pandas import pd

Cell = str | int | float | None  # a value in a table
Row = dict[str, Any]  # a row of a table: column -> value, None where it has none
Columns = Mapping[str, type]


def _of(kind: type, names: str) -> dict[str, type]:
    return dict.fromkeys(names.split(), kind)


# What was run (see `columns`), and whether it is a protocol as the paper prints it.
CARD: Columns = {**{name: column.kind for name, column in RUN.items()}, "as_printed": bool}
LOOP_CARD: Columns = {name: column.kind for name, column in LOOP.items()}

# What the test set depends on: two settings that agree here were judged on the same data.
TEST_SET = ("system", "reading", "regime", "episode_steps", "reset", "damping")

PLACE = _of(str, "run experiment scale setting")
# Of `runs`: `config` holds the settings of the run by dotted key, as JSON; `changed` the keys of those that are not the
# usual ones, with blanks between them. `control` has one row per closed loop; `stages` one per stage of a run, upstream
# first, with `libraries` and `config` as JSON. `bench`: with a metric, trainings until it falls to `goal`, which was
# reached from so many of the starts; without one, single steps.
TABLES: Mapping[str, Columns] = {
    "metrics": {**PLACE, **CARD, "member": int, **_of(str, "split metric"), "value": float, "unit": str},
    "runs": {
        **PLACE,
        **CARD,
        **_of(str, "config changed outcome error"),
        "stale": bool,
        **_of(list, "seeds member_status"),
        "command": str,
    },
    "curves": {"run": str, **_of(int, "member step"), "name": str, "value": float},
    "trajectories": {"run": str, "member": int, "name": str, **_of(float, "t value")},
    "bench": {
        **_of(str, "run name ours other size"),
        "members": int,
        "metric": str,
        "goal": float,
        **_of(int, "starts ours_reached other_reached"),
        **_of(float, "ratio_median ratio_q25 ratio_q75 ratio_least ratio_greatest ours_ms other_ms ours_mib other_mib"),
        "threads": int,
        **_of(str, "protocol command"),
    },
    "identifiability": {"run": str, "member": int, "phase": str, "order": int, "value": float, "direction": str},
    "control": {
        **_of(str, "run experiment scale"),
        "member": int,
        **LOOP_CARD,
        "x_des": float,
        "start": str,
        **_of(float, "start_x start_theta start_theta1 start_theta2"),
        **_of(bool, "success contact"),
        **_of(float, "clearance_min_m held_from_s steady_error_m"),
        **_of(float, "solve_ms_median solve_ms_p95 solve_ms_p99 iterations_median"),
        **_of(int, "fallbacks fallbacks_1 fallbacks_2 fallbacks_3 killed"),
    },
    "closed_loops": {"run": str, **_of(int, "loop member"), "x_des": float, "name": str, **_of(float, "t value")},
    # Of sensitivity runs alone.
    "cases": _of(str, "assumption choice alternative claim experiment run instead"),
    "stages": {
        **_of(str, "run stage id started"),
        **_of(float, "wall_s cpu_s peak_memory_mib"),
        "commit": str,
        "clean": bool,
        **_of(str, "python system processor"),
        "cores": int,
        **_of(str, "libraries config"),
    },
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
    if pd.api.types.is_scalar(value) and pd.isna(value):
        return None
    return value.item() if hasattr(value, "item") else value


def cell_text(value: object) -> str:
    """Spell one cell of a table, with nothing for what is missing."""
    return as_text(plain(value))


def records(table: "pd.DataFrame") -> list[Row]:
    """Return the rows with Python values, None where one is missing."""
    columns = [
        [None if missing else value for value, missing in zip(table[name].tolist(), table[name].isna(), strict=True)]
        for name in table
    ]
    return [dict(zip(table.columns, row, strict=True)) for row in zip(*columns, strict=True)]


def as_column(kind: type, value: object) -> Cell:
    """Bring one value to its column's type; None stays None for numbers and becomes empty text."""
    typed: Cell = as_text(value) if kind is str else None if value is None else kind(value)
    return typed
