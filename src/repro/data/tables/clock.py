"""Time stamps in seconds: numbers, dates, or counts since 1970."""

from typing import TYPE_CHECKING

import numpy as np

from repro.data.tables.table import RecordedTable
from repro.data.tables.units import factor
from repro.errors import UserError

if TYPE_CHECKING:
    import pandas as pd

# Counts since 1970 of the years 1990 to 2100, by their unit. No recording lasts as long in any other unit.
EPOCH = {"ms": (0.6e12, 4.2e12), "us": (0.6e15, 4.2e15), "ns": (0.6e18, 4.2e18)}


def seconds(table: RecordedTable, name: str, unit: str | float | None) -> tuple[np.ndarray, list[str]]:
    """Stamps (sample,) in s, and what was recognised; unit: of the column, None for seconds.

    Dates, and counts of ms, us or ns since 1970, are measured from the first row. UserError for anything else.
    """
    import pandas as pd

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


def _counted(series: "pd.Series", table: RecordedTable, unit: str | float | None) -> tuple[np.ndarray, list[str]]:
    if unit is not None:
        return table.numbers([str(series.name)])[:, 0] * factor(unit, time=True), []
    first = series.dropna().iloc[:1]
    for name, (low, high) in EPOCH.items():
        if len(first) and low < float(first.iloc[0]) < high:
            relative = (series - first.iloc[0]).to_numpy(dtype=float, na_value=np.nan)
            note = f"{series.name} holds counts of {name} since 1970: taken as s from the first"
            return relative * factor(name, time=True), [note]
    return table.numbers([str(series.name)])[:, 0], []
