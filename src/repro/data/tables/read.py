"""Reads the table in one file, whatever its name ends in: Parquet and gzip are known by their first bytes.

All else is delimited text: separators, decimal commas, comment lines, a row of units, separators at the ends of lines.
"""

import csv
import gzip
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO, StringIO
from pathlib import Path

import numpy as np
import pandas as pd

from repro.errors import UserError
from repro.plugins.plugin import nearest

GZIP, PARQUET = b"\x1f\x8b", b"PAR1"
FORMATS = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".pq", ".gz")  # what is taken of a folder


@dataclass(frozen=True)
class RecordedTable:
    """The content of a file."""

    path: Path
    frame: pd.DataFrame  # one row per sample
    twice: frozenset[str] = frozenset()  # names that stand twice in the line of names
    units: Mapping[str, str] = field(default_factory=dict)  # what a row of units below the names says, by name

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


def read_table(path: Path) -> RecordedTable:
    """The table in a file; UserError where there is none."""
    try:
        content = path.read_bytes()
        if content.startswith(GZIP):
            content = gzip.decompress(content)
    except (OSError, EOFError) as error:
        raise UserError(f"{path}: cannot be read ({error})") from error
    table = RecordedTable(path, _parquet(path, content)) if content.startswith(PARQUET) else read_text(path, content)
    if table.frame.empty:
        raise UserError(f"{path}: the file has no rows")
    return table


def files_of(path: Path) -> list[Path]:
    """The file itself, or the recordings in a folder in the order of their names, 2 before 10; UserError for none."""
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise UserError(f"{path}: there is no such file or folder")
    found = [each for each in path.iterdir() if each.suffix.lower() in FORMATS and not each.name.startswith(".")]
    if not found:
        raise UserError(f"{path}: the folder has no file that ends in {', '.join(FORMATS)}")
    parts = {file: re.split(r"(\d+)", file.name) for file in found}
    return sorted(found, key=lambda file: [part.zfill(12) if part.isdigit() else part for part in parts[file]])


def _parquet(path: Path, content: bytes) -> pd.DataFrame:
    try:
        frame = pd.read_parquet(BytesIO(content))
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: cannot be read as Parquet ({' '.join(str(error).split())})") from error
    if any(name is not None for name in frame.index.names):
        frame = frame.reset_index()
    lists = [name for name in frame.columns if len(frame) and isinstance(frame[name].iloc[0], list | np.ndarray)]
    for name in lists:
        if len({len(value) for value in frame[name]}) > 1:
            raise UserError(f"{path}: the lists of column {name!r} have different lengths")
        values = np.stack(frame[name].to_list())
        for index in range(values.shape[1]):
            frame[f"{name}[{index}]"] = values[:, index]
    return frame.drop(columns=lists)


SEPARATORS = (",", ";", "\t", "|", " ")  # " ": any run of blanks
COMMENTS = ("#", "%", "//", "sep=")  # begin lines that hold no data; spreadsheets write the last one
PROBED = 200  # lines from which the separator and the decimal sign are found
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")


def read_text(path: Path, content: bytes) -> RecordedTable:
    """The table in a text file; UserError where there is none."""
    lines = [line for line in _decoded(path, content).splitlines() if line.strip()]
    comments = [line for line in lines if line.lstrip().startswith(COMMENTS)]
    rows = [line for line in lines if not line.lstrip().startswith(COMMENTS)]
    if not rows:
        raise UserError(f"{path}: the file has no rows")
    separator = max(SEPARATORS, key=lambda each: _score(rows[:5], each))
    header = _split(rows[0], separator)
    numbers = sum(map(_is_number, header))
    commented = _commented_names(comments, separator, len(header)) if numbers else None
    if commented is None and numbers == len(header):
        raise UserError(f"{path}: there is no line of column names above the numbers; write one")
    header, rows = (header, rows[1:]) if commented is None else (commented, rows)
    units: dict[str, str] = {}
    numeric = [any(map(_is_number, _split(row, separator))) for row in rows[:2]]
    if numeric == [False, True]:
        units = dict(zip(header, _split(rows[0], separator), strict=False))
        rows = rows[1:]
    twice = frozenset(name for name in header if name and header.count(name) > 1)
    names = [name if name and name not in header[:i] else f"column {i + 1}" for i, name in enumerate(header)]
    return RecordedTable(path, _parsed(path, rows, names, separator), twice, units)


def _decoded(path: Path, content: bytes) -> str:
    utf16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        text = content.decode("utf-16" if utf16 else "utf-8-sig")
    except UnicodeDecodeError:
        if utf16:
            raise UserError(f"{path}: cannot be read as text (damaged UTF-16)") from None
        text = content.decode("latin-1")
    if "\0" in text:
        raise UserError(f"{path}: cannot be read: neither text nor Parquet; export it as CSV or Parquet")
    return text


def _split(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]


def _is_number(cell: str) -> bool:
    """Whether a cell is a number, with a decimal point or a decimal comma."""
    try:
        float(cell.replace(",", ".", 1))
    except ValueError:
        return False
    return True


def _score(lines: Sequence[str], separator: str) -> tuple[int, int]:
    """How well a separator explains the first lines: rows as long as the names, then the numbers in the last one."""
    header, *rows = (_split(line, separator) for line in lines)
    if len(header) < 2:
        return 0, 0
    fitting = sum(len(row) - len(header) in (0, 1) for row in rows)
    return fitting, sum(map(_is_number, rows[-1])) if rows else len(header)


def _commented_names(comments: Sequence[str], separator: str, count: int) -> list[str] | None:
    for line in reversed(comments):
        names = _split(line.lstrip().lstrip("#%/").strip(), separator)
        if len(names) == count:
            return names
    return None


def _parsed(path: Path, rows: Sequence[str], names: Sequence[str], separator: str) -> pd.DataFrame:
    cells = [cell for row in rows[:PROBED] for cell in _split(row, separator)] if separator != "," else []
    decimal = "," if any(map(DECIMAL_COMMA.fullmatch, cells)) else "."
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)
            # Without index_col=False a separator at the end of every line would shift all columns by one.
            return pd.read_csv(
                StringIO("\n".join(rows)),
                sep=r"\s+" if separator == " " else separator,
                decimal=decimal,
                header=None,
                names=list(names),
                index_col=False,
                skipinitialspace=True,
                low_memory=False,
            )
    except pd.errors.ParserWarning:
        raise UserError(f"{path}: rows have more values than the {len(names)} column names") from None
    except (OSError, ValueError) as error:  # the parsers' own errors are ValueErrors
        raise UserError(f"{path}: cannot be read as text ({' '.join(str(error).split())})") from error
