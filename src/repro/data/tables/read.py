"""Reads one file, whatever its name ends in: Parquet and gzip are known by their first bytes, all else is text."""

import gzip
import re
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd

from repro.data.tables.table import RecordedTable
from repro.data.tables.text import read_text
from repro.errors import UserError

GZIP, PARQUET = b"\x1f\x8b", b"PAR1"
FORMATS = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".pq", ".gz")  # what is taken of a folder


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
