"""Units of recorded columns as factors to SI units; time stamps (numbers, dates, counts since 1970) in seconds."""

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from repro.data.tables.read import RecordedTable
from repro.errors import UserError

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
OTHERS = {
    **{"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    **{"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "turn": 2 * math.pi, "rpm": 2 * math.pi / 60},
    **{"N": 1.0, "kN": 1e3, "mN": 1e-3, "N m": 1.0, "Nm": 1.0, "mN m": 1e-3, "mNm": 1e-3},
}
RATES = ("/s^2", "/s2", "/s²", "/s")  # may follow the unit of a coordinate
# Counts since 1970 of the years 1990 to 2100, by their unit. No recording lasts as long in any other unit.
EPOCH = {"ms": (0.6e12, 4.2e12), "us": (0.6e15, 4.2e15), "ns": (0.6e18, 4.2e18)}


def factor(unit: str | float, *, time: bool = False) -> float:
    """What a number in this unit, or with this factor, is multiplied by; UserError names the units there are."""
    if not isinstance(unit, str):
        if not math.isfinite(unit) or unit == 0:
            raise UserError(f"data.units: {unit} is no factor: give a unit, or a number other than 0")
        return float(unit)
    known = SECONDS if time else OTHERS
    base = next((unit.removesuffix(end) for end in RATES if not time and unit.endswith(end)), unit)
    if base not in known:
        raise UserError(f"data.units: {unit!r} is not known; allowed are {', '.join(known)}, or a factor to SI units")
    return known[base]


def factors(units: Sequence[str | float], columns: int, role: str) -> list[float]:
    """One factor per column, 1 where no units are given; UserError where there are not as many units as columns."""
    if not units:
        return [1.0] * columns
    if len(units) != columns:
        raise UserError(f"data.units.{role} = {list(units)}: needs one unit for each of the {columns} columns, or none")
    return [factor(unit, time=role == "time") for unit in units]


def seconds(table: RecordedTable, name: str, unit: str | float | None) -> tuple[np.ndarray, list[str]]:
    """Stamps (sample,) in s, and what was recognised; unit: of the column, None for seconds.

    Dates, and counts of ms, us or ns since 1970, are measured from the first row. UserError for anything else.
    """
    series = table.frame[name]
    if pd.api.types.is_timedelta64_dtype(series):
        return series.dt.total_seconds().to_numpy(), []
    if pd.api.types.is_numeric_dtype(series) and not pd.api.types.is_bool_dtype(series):
        return _counted(series, table, unit)
    if not pd.api.types.is_datetime64_any_dtype(series):
        numbers = pd.to_numeric(series, errors="coerce")
        if numbers.notna().any():
            return table.numbers([name])[:, 0], []  # or the line that says which cell is no number
        try:
            series = pd.to_datetime(series, format="ISO8601", utc=True)
        except (ValueError, TypeError):
            raise UserError(
                f"{table.path}: column {name!r} holds {str(series.iloc[0])!r}, neither a number of seconds nor a date "
                "such as 2026-03-01 12:00:00.020"
            ) from None
    return (series - series.iloc[0]).dt.total_seconds().to_numpy(), [f"{name} holds dates: taken as s from the first"]


def _counted(series: pd.Series, table: RecordedTable, unit: str | float | None) -> tuple[np.ndarray, list[str]]:
    if unit is not None:
        return table.numbers([str(series.name)])[:, 0] * factor(unit, time=True), []
    first = series.dropna().iloc[:1]
    for name, (low, high) in EPOCH.items():
        if len(first) and low < float(first.iloc[0]) < high:
            relative = (series - first.iloc[0]).to_numpy(dtype=float, na_value=np.nan)
            note = f"{series.name} holds counts of {name} since 1970: taken as s from the first"
            return relative * factor(name, time=True), [note]
    return table.numbers([str(series.name)])[:, 0], []
