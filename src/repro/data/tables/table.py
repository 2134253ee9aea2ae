"""One table of a recording: its columns by name, and the numbers in them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from repro.errors import UserError
from repro.plugins.plugin import nearest


@dataclass(frozen=True)
class RecordedTable:
    """The content of a file.

    frame  one row per sample
    twice  names that stand twice in the line of names
    units  what a row of units below the names says, by name
    """

    path: Path
    frame: pd.DataFrame
    twice: frozenset[str] = frozenset()
    units: Mapping[str, str] = field(default_factory=dict)

    def names(self, wanted: Sequence[str]) -> list[str]:
        """The columns of these names, a list column as its elements NAME[0], NAME[1], ...; UserError for others."""
        found = []
        for name in wanted:
            if name in self.twice:
                raise UserError(f"{self.path}: the column name {name!r} stands twice; rename one of the two")
            if name in self.frame.columns:
                found.append(name)
                continue
            columns = [str(column) for column in self.frame.columns]
            elements = [column for column in columns if re.fullmatch(rf"{re.escape(name)}\[\d+\]", column)]
            if not elements:
                raise UserError(
                    f"{self.path}: there is no column {name!r}{nearest(name, columns)}; it has {', '.join(columns)}"
                )
            found += elements
        return found

    def numbers(self, names: Sequence[str]) -> np.ndarray:
        """(sample, column) numbers, not finite where one is missing; UserError for a cell that is no number."""
        return np.column_stack([self._column(name) for name in names])

    def _column(self, name: str) -> np.ndarray:
        series = self.frame[name]
        if pd.api.types.is_bool_dtype(series) or pd.api.types.is_datetime64_any_dtype(series):
            what = "true and false" if pd.api.types.is_bool_dtype(series) else "dates"
            raise UserError(f"{self.path}: column {name!r} holds {what}, not numbers")
        try:
            return series.to_numpy(dtype=float, na_value=np.nan)
        except (TypeError, ValueError):
            numbers = pd.to_numeric(series, errors="coerce")
            row = int(np.argmax((numbers.isna() & series.notna()).to_numpy()))
            raise UserError(
                f"{self.path}: column {name!r} holds {str(series.iloc[row])!r} in data row {row + 1}, "
                "which is no number"
            ) from None
